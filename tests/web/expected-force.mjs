// SPDX-License-Identifier: LGPL-2.1-or-later
// What the track of a film lets a hand feel, computed without a browser.
import { readFileSync } from 'node:fs';
import { ForceChain } from '../../pipelines/web/player/force-chain.js';
import { MotionTrack } from '../../pipelines/web/player/motion-track.js';
import { readPackets } from '../../pipelines/web/player/plain-hls.js';

/** @returns [s of the film, N] at each frame of a screen that misses none. `segment` is a file of make-cmaf.mjs. */
export function expectedForces(segment, { place, alpha, until, rate = 1 }) {
  const track = new MotionTrack(), chain = new ForceChain(), forces = [];
  for (const { time, bytes } of readPackets(readFileSync(segment), 0)) track.add(bytes, time);
  chain.alpha = alpha;
  for (let time = 0; time < until; time += rate / 60) {
    const { x, y } = chain.advance(time, (time, since) => track.at(time, place, since), rate);
    forces.push([chain.time, Math.hypot(x, y)]);
  }
  return forces;
}

/** Whether these forces are felt all the time about `at`, s of the film. */
export const isFelt = (forces, at) => forces.every(([time, newtons]) => Math.abs(time - at) > 0.1 || newtons > 0.01);
