// SPDX-License-Identifier: MIT
// A thing of a field that is held (docs/formats/motion-field.md), or what moves about a place: in single precision, in the
// order of gst-plugins/device/motion/field-hold.cpp, so that both give the same bits.
import { CUT, clamp, fround } from './field-codec.js';
import { regionSide, sampleField } from './field-sampler.js';

const HEADER = 4, SIZE = 12; // bytes, of all things and of each
const STATES = ['none', 'held', 'about', 'hidden', 'lost'];
const STEPS = 65535;
const REACH = 24, REACH_WIDTH = 1920; // px, in a frame of this width: a thing this near is taken
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

const seconds = us => fround(fround(us * 1000) * fround(1e-9));

export class FieldHold {
  #id = null; // of the thing; null: about the place
  /** {state: held, about, hidden or lost, x, y, radius, time: s since the press}, or null */
  held = null;
  /** px/s, y down */
  x = 0;
  y = 0;
  confidence = 0;

  /** Takes the thing at a place of the frame, or else what moves about the place. */
  press(x, y, field) {
    [x, y] = [fround(x), fround(y)];
    const { width, height } = field;
    let taken = null, least = Infinity; // px^2
    for (const thing of readThings(field.things)) {
      const dx = fround(fround(thing.x - x) * width), dy = fround(fround(thing.y - y) * height);
      const distance = fround(fround(dx * dx) + fround(dy * dy));
      const reach = Math.max(fround(thing.radius * width), fround(fround(REACH * width) / REACH_WIDTH));
      if (thing.state !== 'held' || !(distance <= fround(reach * reach)) || !(distance < least)) continue;
      [taken, least] = [thing, distance];
    }
    this.#id = taken?.id ?? null;
    this.#say(taken ?? { state: 'about', x, y, radius: fround(regionSide(width, height, 0) / 2 / width) }, 0);
  }

  release() { this.held = null; }

  /** The next field of the film. */
  step(field) {
    if (!this.held || this.held.state === 'lost') return;
    const before = this.held, time = before.time + field.interval / 1e6;
    if (field.flags & (CUT | DISCONTINUITY)) return this.#say({ ...before, state: 'lost' }, time);
    const interval = seconds(field.interval);
    if (this.#id === null) return this.#drift(field, interval, time);
    const thing = readThings(field.things).find(({ id }) => id === this.#id);
    this.#say(thing ?? { ...before, state: 'lost' }, time);
    if (thing?.state !== 'held') return;
    this.confidence = 1;
    if (before.state !== 'held' || !(interval > 0)) return;
    this.x = fround(fround(fround(thing.x - before.x) * field.width) / interval);
    this.y = fround(fround(fround(thing.y - before.y) * field.height) / interval);
  }

  #drift(field, interval, time) {
    const { x, y, confidence } = sampleField(field, this.held);
    const next = (place, speed, size) => clamp(fround(place + fround(fround(speed * interval) / size)), 0, 1);
    this.#say({ ...this.held, x: next(this.held.x, x, field.width), y: next(this.held.y, y, field.height) }, time);
    Object.assign(this, { x, y, confidence });
  }

  #say({ state, x, y, radius }, time) {
    this.held = { state, x, y, radius, time };
    this.x = this.y = this.confidence = 0;
  }
}
