# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash
# Cases that repeat for statistics or for hours what others check once, or that only measure time. A sanitizer or an emulator
# would find nothing more in them. To be sourced.
repetitions=(
  '*.F20_*' '*.F27_*' '*/ClosedLoop.*' '*/SlipOn.*' 'OurPart.OfATickIsMeasured*'
  'FastTracker.HoldsUpToSixteenPixels' 'FastTracker.EverySixteenthOfAPixelHasTheSameSmallBias'
  '*TrackerLimits.AfterTheFirst*NothingIsAllocated' 'FastTracker.ChangesOfGainAndOffsetDoNotMoveAnything'
  'PoseSolver.TheOrientationStaysARotation*' 'TensionSolver.AgreesWithBruteForce*'
  'OpencvTracker.AlmostNeverErrsGrosslyUpToSixteenPixels'
  '*MotionModels.TheSmallestThatExplainsTheSceneIsChosen*' 'UniformMotion.*'
  '*.NeitherGainEnergyNorTrembleOnRandomSurfaces/*' '*.OverAStillFrameATapOnALightHandComesToRest/*'
  '*.LateTicksDoNotMakeAHand*' '*.NoLivelyHandIsTakenForAShakingOne/*' '*/FreeGrip.TurnsWithAtMost*'
  '*.WhatTheForceHasSpentRemainsSpentInTheNextRun*' 'ContinuousForceBudget.IsNeverExceededOverAMinute*'
  'SafetyChain.NeitherSlewRateNorForceNorSpeedAddsToTheWork*' 'Faults.F5_FiveHundred*' 'Faults.F6_FiveHundred*'
)

# Prints a filter for GoogleTest that leaves them out.
without_repetitions() {
  (IFS=: && echo "-${repetitions[*]}")
}
