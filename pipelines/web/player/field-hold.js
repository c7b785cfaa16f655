// SPDX-License-Identifier: MIT
// A thing of a field that is held (docs/formats/motion-field.md), or what moves about a place: in single precision, in the
// order of gst-plugins/device/motion/field-hold.cpp, so that both give the same bits.
import { CUT, clamp, fround } from './field-codec.js';
import { regionSide, sampleField } from './field-sampler.js';

const HEADER = 4, SIZE = 12; // bytes, of all things and of each
const STATES = ['none', 'held', 'about', 'hidden', 'lost'];
const STEPS = 65535;
const LEAST_REACH = fround(0.0125); // of the width: 24 px of 1920
const DISCONTINUITY = 8; // flag: there is no earlier frame

/** @returns {id, state, x, y: fractions of the frame, radius: of its width} of each thing in the bytes of KLV */
export function readThings(bytes) {
  if (!bytes?.length) return [];
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  return Array.from({ length: bytes[0] }, (_, i) => {
    const at = HEADER + SIZE * i;
    const [x, y, radius] = [4, 6, 8].map(offset => fround(view.getUint16(at + offset, true) / STEPS));
    return { id: view.getUint16(at, true), state: STATES[bytes[at + 2]], x, y, radius };
  });
}

const seconds = us => fround(us * 1000 * 1e-9);
const halfRegion = ({ width, height }, z) => fround(regionSide(width, height, z) / (2 * width));

export class FieldHold {
  /** px/s, y down */
  x = 0;
  y = 0;
  confidence = 0;
  /** {id: of the thing, or null, state: held, about, hidden or lost, x, y, radius, time: s since the press}, or null */
  held = null;

  /** Takes the thing at a place of the frame, or else what moves about the place. Its motion is that of the place. */
  press(place, field) {
    const { width, height } = field, x = fround(place.x), y = fround(place.y);
    Object.assign(this, sampleField(field, place));
    let held = { id: null, state: 'about', x, y, radius: halfRegion(field, place.z ?? 0) }, nearest = Infinity; // px^2
    for (const thing of readThings(field.things)) {
      const dx = fround(fround(thing.x - x) * width), dy = fround(fround(thing.y - y) * height);
      const distance = fround(fround(dx * dx) + fround(dy * dy));
      const reach = fround(Math.max(thing.radius, LEAST_REACH) * width);
      if (thing.state === 'hidden' || distance > fround(reach * reach) || distance >= nearest) continue;
      [held, nearest] = [thing, distance];
    }
    this.held = { ...held, time: 0 };
  }

  release() { this.held = null; }

  /** The fields that follow are of elsewhere in the film. */
  lose() { this.held = { ...this.held, state: 'lost' }; }

  /** The next field of the film; `z` is that of the hand. */
  step(field, z = 0) {
    const before = this.held;
    if (!before) return;
    const held = this.held = { ...before, time: before.time + field.interval / 1e6 };
    this.x = this.y = this.confidence = 0;
    const thing = held.id === null ? held : readThings(field.things).find(({ id }) => id === held.id);
    if (!thing || field.flags & (CUT | DISCONTINUITY)) held.state = 'lost';
    if (held.state === 'lost') return;
    if (thing === held) return this.#drift(field, z);
    Object.assign(held, thing);
    if (held.state === 'about') this.#feelRegion(field, z);
    const interval = seconds(field.interval);
    if (held.state !== 'held' || before.state !== 'held' || !(interval > 0)) return;
    this.x = fround(fround(fround(held.x - before.x) * field.width) / interval);
    this.y = fround(fround(fround(held.y - before.y) * field.height) / interval);
    this.confidence = 1;
  }

  #feelRegion(field, z) {
    Object.assign(this, sampleField(field, { ...this.held, z }));
  }

  #drift(field, z) {
    this.#feelRegion(field, z);
    const { held } = this, interval = seconds(field.interval);
    const moved = (place, speed, size) => clamp(fround(place + fround(fround(speed * interval) / size)), 0, 1);
    held.radius = halfRegion(field, z);
    held.x = moved(held.x, this.x, field.width);
    held.y = moved(held.y, this.y, field.height);
  }
}
