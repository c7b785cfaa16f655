// SPDX-License-Identifier: MIT
// From a force to the motors of a gamepad or a phone (docs/web.md, "What a gamepad feels"). An effect ends by itself
// 60 ms after it was asked for, also when the page dies; while a force lasts it is renewed.

const LASTS = 60; // ms
const RENEWED = 30; // ms after the effect before
const CHANGE = 0.02; // of a magnitude, that makes a new effect at once
const CLOSEST = 15; // ms between two effects
const LEAST = 0.02; // of the full force; below it the motors rest
const PHONE_PERIOD = 50; // ms, three frames of most screens

/** Magnitudes for a force of `newtons`, of which `full` are full; `strength` 0..1. */
export function magnitudes(newtons, full, strength) {
  const share = newtons / full * strength;
  const m = share >= LEAST ? Math.min(share, 1) : 0; // NaN is no force
  return { strongMagnitude: m * m, weakMagnitude: m };
}

/**
 * The gamepads that are connected and whose layout the browser knows: a wheel has none, and its pedals at rest are no
 * centre. None in a frame whose policy forbids them, where asking is an error.
 */
export function gamepads() {
  try {
    return Array.from(navigator.getGamepads?.() ?? []).filter(pad => pad?.connected && pad.mapping === 'standard');
  } catch {
    return [];
  }
}

/** Whether the first button of one is pressed. */
export const isButtonDown = () => gamepads().some(pad => pad.buttons?.[0]?.pressed);

/** Those that can rumble. */
export const rumblePads = () => gamepads().filter(({ vibrationActuator: actuator }) =>
  actuator?.playEffect && (actuator.effects?.includes('dual-rumble') ?? true));

const canVibrate = () => Boolean(navigator.vibrate) && matchMedia('(pointer: coarse)').matches &&
  (navigator.userActivation?.hasBeenActive ?? true);

export class Rumble {
  #sent = { strongMagnitude: 0, weakMagnitude: 0 };
  #time = -Infinity; // ms, of the last effect
  #actuators = new Set(); // that play one
  #phone = false;

  get active() { return this.#sent.weakMagnitude > 0; }

  /** `now` in ms of performance.now(). */
  play(wanted, now) {
    if (!(wanted.weakMagnitude > 0)) return this.stop();
    const change = Math.abs(wanted.weakMagnitude - this.#sent.weakMagnitude);
    const since = now - this.#time;
    if (since < CLOSEST) return;
    const actuators = new Set(rumblePads().map(pad => pad.vibrationActuator));
    if (actuators.size === 0) return this.#vibrate(wanted, now);
    if (since < RENEWED && change < CHANGE) return;
    this.#sent = wanted;
    this.#time = now;
    for (const actuator of actuators) quietly(actuator.playEffect('dual-rumble', { duration: LASTS, ...wanted }));
    this.#actuators = actuators;
  }

  // A phone knows on and off only: on for the share of the force. A new call ends the one before, so that there is one
  // a period, at the frame of the screen that is nearest.
  #vibrate(wanted, now) {
    if (now - this.#time < PHONE_PERIOD - 8 || !canVibrate()) return;
    this.#sent = wanted;
    this.#time = now;
    this.#phone = navigator.vibrate(Math.round(wanted.weakMagnitude * PHONE_PERIOD));
  }

  /** Zero now. */
  stop() {
    if (!this.active) return;
    this.#sent = { strongMagnitude: 0, weakMagnitude: 0 };
    this.#time = -Infinity;
    for (const actuator of this.#actuators) quietly(actuator.reset());
    this.#actuators.clear();
    if (this.#phone) navigator.vibrate(0);
    this.#phone = false;
  }
}

// A newer effect or a lost gamepad refuses an older one, which is no error.
function quietly(promise) {
  Promise.resolve(promise).catch(() => {});
}
