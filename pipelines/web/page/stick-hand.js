// SPDX-License-Identifier: LGPL-2.1-or-later
// The left stick of a gamepad moves the hand, faster the farther it is pushed.
import { gamepads } from '../player/rumble.js';

const SPEED = 0.6; // of the picture in 1 s, at full deflection
const REST = 0.15; // a stick at rest is not quite at zero
const LONGEST = 0.1; // s between two steps

export class StickHand {
  #time = 0; // ms

  /** @returns how far the hand moves until `now` (ms), in parts of the picture, or null */
  step(now) {
    const seconds = Math.min((now - this.#time) / 1000, LONGEST);
    this.#time = now;
    const pad = gamepads().find(({ axes }) => Math.hypot(axes?.[0], axes?.[1]) > REST);
    if (!pad) return null;
    const [x, y] = pad.axes;
    const length = Math.hypot(x, y);
    const share = Math.min((length - REST) / (1 - REST), 1) / length;
    return { x: x * share * SPEED * seconds, y: y * share * SPEED * seconds };
  }
}
