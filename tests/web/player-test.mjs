// SPDX-License-Identifier: LGPL-2.1-or-later
// The player without a browser: a phone that vibrates, a gamepad and a wheel, and motion that is no number.
import { ForceChain } from '../../pipelines/web/player/force-chain.js';
import { StickHand } from '../../pipelines/web/page/stick-hand.js';
import { Rumble, isButtonDown, magnitudes } from '../../pipelines/web/player/rumble.js';
import { promise } from './promise.mjs';

// ---- a phone, which writes down when its motor is on

const pulses = []; // {at, on: ms}
let active = true;
let pads = [null];
const navigator = {
  getGamepads: () => pads,
  userActivation: { get hasBeenActive() { return active; } },
  vibrate(on) {
    const last = pulses.at(-1);
    if (last) last.on = Math.min(last.on, now - last.at);
    pulses.push({ at: now, on });
    return true;
  },
};
Object.defineProperty(globalThis, 'navigator', { value: navigator, configurable: true });
globalThis.matchMedia = () => ({ matches: true });
let now = 0; // ms

// The share of 2 s for which the motor is on, with a force of `newtonsAt(frame)` at each frame of a screen.
function shareOn(hertz, newtonsAt) {
  pulses.length = 0;
  const rumble = new Rumble();
  const begin = now;
  for (let frame = 0; frame < 2 * hertz; ++frame) {
    now = begin + 1000 * frame / hertz;
    rumble.play(magnitudes(newtonsAt(frame), 1, 1), now);
  }
  now = begin + 2000;
  rumble.stop();
  promise('a pulse ends by itself within 60 ms', pulses.every(({ on }) => on <= 60));
  const sum = pulses.reduce((sum, { on }) => sum + on, 0);
  now += 1000;
  return sum / 2000;
}
for (const hertz of [60, 90, 120])
  for (const force of [0.1, 0.5, 0.9, 1]) {
    const [steady, lively] = [shareOn(hertz, () => force), shareOn(hertz, frame => force + (frame % 2 ? 0.04 : -0.04))];
    console.log(`${hertz} Hz, ${force} N: ${(100 * steady).toFixed(0)} %, lively ${(100 * lively).toFixed(0)} %`);
    promise('a phone is on for the share of the force', Math.abs(steady - force) < 0.15 * force);
    promise('also if the force changes with each frame', Math.abs(lively - force) < 0.2 * force + 0.03);
  }

const phone = new Rumble();
pulses.length = 0;
phone.play(magnitudes(1, 1, 1), now);
phone.stop();
promise('zero is zero at once', pulses.length === 2 && pulses[1].on === 0);
active = false;
phone.play(magnitudes(1, 1, 1), now += 100);
promise('nothing is asked before the first tap', pulses.length === 2);
active = true;

// ---- a wheel, whose pedal rests at the end of its axis, and a gamepad

let effects = 0;
const vibrationActuator = { playEffect: () => Promise.resolve(++effects), reset: () => Promise.resolve() };
const moves = mapping => {
  pads = [{ connected: true, mapping, axes: [0, 1], buttons: [{ pressed: true }], vibrationActuator }];
  effects = 0;
  const rumble = new Rumble();
  rumble.play(magnitudes(1, 1, 1), now += 100);
  rumble.stop();
  return { felt: effects > 0, hand: new StickHand().step(now) !== null, pressed: isButtonDown() };
};
const pad = moves('standard');
promise('a gamepad vibrates, moves the hand and presses', pad.felt && pad.hand && pad.pressed);
const wheel = moves('');
promise('a wheel does none of it', !wheel.felt && !wheel.hand && !wheel.pressed);
pads = [null];

// ---- a motion that is no number

const chain = new ForceChain();
const still = { x: 0, y: 0, confidence: 1, measured: true, cut: false, age: 0, interval: 0.04, width: 352, aspect: 1 };
chain.advance(10, () => still);
chain.advance(10.02, () => ({ ...still, x: NaN }));
promise('it is zero, and time goes on', chain.silent && Math.abs(chain.time - 10.02) < 1e-6);
