// SPDX-License-Identifier: LGPL-2.1-or-later
// For who has a mouse or a finger only: the drawn hand is blown away from the pointer by the force (docs/web.md,
// "Without a device"; pseudo-haptics, Lécuyer 2000). What is felt is still measured at the pointer.

const FARTHEST = 0.08; // of the picture's height

/** How far the drawn hand is from the pointer, in heights of the picture, y down; `share` of FARTHEST at 1 N. */
export function blownBy({ x, y }, share) {
  const scale = FARTHEST * share / Math.max(Math.hypot(x, y), 1);
  return { x: x * scale, y: -y * scale };
}

/** Whether a hand may be blown: not beside a device that is felt, nor for who wants no motion. */
export const mayBeBlown = player => player.gamepads.length === 0 &&
  !matchMedia('(prefers-reduced-motion: reduce)').matches;
