// SPDX-License-Identifier: LGPL-2.1-or-later
// A gamepad that writes down what is asked of it: headless Chromium has none.

/** Runs in the page before its scripts. window.motor: what was asked; motorAt(ms): how strong it is then. */
export function installGamepad() {
  const asked = [];
  const actuator = {
    effects: ['dual-rumble'],
    playEffect(type, { duration, strongMagnitude, weakMagnitude }) {
      asked.push({ at: performance.now(), duration, strong: strongMagnitude, weak: weakMagnitude });
      return Promise.resolve('complete');
    },
    reset() {
      asked.push({ at: performance.now(), duration: 0, strong: 0, weak: 0 });
      return Promise.resolve('complete');
    },
  };
  const pad = {
    id: 'Test pad (Vendor: 0001)', index: 0, connected: true, mapping: 'standard', axes: [0, 0], buttons: [],
    vibrationActuator: actuator,
  };
  let pads = [pad, null, null, null];
  navigator.getGamepads = () => pads;
  window.motor = asked;
  window.stick = pad.axes;
  window.motorAt = time => {
    const last = asked.findLast(effect => effect.at <= time);
    return last && time < last.at + last.duration ? last.weak : 0;
  };
  // ms after `since` until the motor rests for good; 0 if it rested then.
  window.restsAfter = since => {
    let rests = since;
    for (const [i, effect] of asked.entries())
      if (effect.weak > 0) rests = Math.max(rests, Math.min(effect.at + effect.duration, asked[i + 1]?.at ?? Infinity));
    return rests - since;
  };
  window.unplug = () => {
    pads = [null, null, null, null];
    window.dispatchEvent(new Event('gamepaddisconnected'));
  };
}
