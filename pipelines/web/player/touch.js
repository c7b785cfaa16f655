// SPDX-License-Identifier: MIT
// The reliefs of a film, and what a finger feels that presses on them. The player loads this file, and all for reliefs
// with it, with the first relief.
import { Contact, HALF, Surface } from './contact.js';
import { EVEN, FieldDecoder, bit, clamp, fround, number, sizeClass } from './field-codec.js';
import { confidenceGate, staleAfter } from './force-chain.js';
import { PacketTrack } from './motion-track.js';

// ---- the cells of reliefs in the code of fields (docs/formats/field-code.md), equal to
// gst-plugins/track/field-code/relief-cells.cpp bit for bit

const LARGEST_STEP = 100_000; // µm
const LARGEST_HEIGHT = 20_000; // steps
const HIGHEST = 1; // m
const LARGEST_STIFFNESS = 134, STIFFEST = 1e5; // N/m
const LARGEST_FRICTION = 200;
const LARGEST_VALIDITY = 4;

// N/m of each number.
const STIFFNESSES = Float32Array.from({ length: LARGEST_STIFFNESS + 1 }, (_, n) =>
  n > 0 ? Math.min(2 ** ((n - 1) / 8), STIFFEST) : 0);

// Places of the models in one array. Heights have 16 bits, the others 8.
const HEIGHT_BITS = 16, BITS = 8;
const HEIGHT_SIZE = HEIGHT_BITS + 4, SIZE = BITS + 4;
const MOVED = 0, TURNED = 8, HEIGHT = 12, STIFFNESS = HEIGHT + 4 * HEIGHT_SIZE;
const FRICTION = STIFFNESS + SIZE, VALIDITY = FRICTION + SIZE;

// The median of left, above, and the plane through both and above left.
function expected(z, i, columns) {
  const hasLeft = i % columns > 0, hasUp = i >= columns;
  if (!hasLeft || !hasUp) return hasLeft ? z[i - 1] : hasUp ? z[i - columns] : 0;
  const left = z[i - 1], up = z[i - columns];
  return clamp(left + up - z[i - columns - 1], Math.min(left, up), Math.max(left, up));
}

// Applies the changes of the code to `cells`.
function decodeCells(cells, columns) {
  const { z, changed } = cells, count = z.length;
  const moved = new Uint8Array(count), turned = new Uint8Array(count);
  const off = new Int32Array(count); // height minus what was expected
  for (let i = 0; i < count; ++i) {
    const left = i % columns > 0 ? i - 1 : -1, up = i - columns; // below 0: there is none
    const upRight = (i + 1) % columns > 0 ? up + 1 : -1;
    moved[i] = bit(MOVED + (moved[left] ?? 0) + (moved[up] ?? 0) + (moved[upRight] ?? 0) + (changed[i] ? 4 : 0));
    turned[i] = bit(TURNED + (turned[left] ?? 0) + (turned[up] ?? 0));
    if (moved[i]) {
      const guess = expected(z, i, columns);
      off[i] = number(HEIGHT + HEIGHT_SIZE * sizeClass(off[left] ?? 0, off[up] ?? 0), HEIGHT_BITS);
      z[i] = clamp(guess + off[i], -LARGEST_HEIGHT, LARGEST_HEIGHT);
    }
    if (turned[i]) turn(cells, i, left >= 0 ? left : up);
    changed[i] = moved[i];
  }
}

// `like`: the cell whose material is expected; below 0: none.
function turn(cells, i, like) {
  for (const [values, model, largest] of [[cells.validity, VALIDITY, LARGEST_VALIDITY],
    [cells.stiffness, STIFFNESS, LARGEST_STIFFNESS], [cells.friction, FRICTION, LARGEST_FRICTION]])
    values[i] = clamp((values[like] ?? 0) + number(model, BITS), 0, largest);
}

/** The kind for FieldDecoder: a field with `z` (m, towards the user), `stiffness` (N/m), `friction`, `validity` 0..1 */
export const RELIEF = {
  fresh: new Uint16Array(VALIDITY + SIZE).fill(EVEN),
  step: LARGEST_STEP,
  make: count => ({
    z: new Int16Array(count), stiffness: new Uint8Array(count), friction: new Uint8Array(count),
    validity: new Uint8Array(count), changed: new Uint8Array(count),
  }),
  decode: decodeCells,
  hashed: ({ z, stiffness, friction, validity }) => [z, stiffness, friction, validity],
  values({ cells, step }) {
    const count = cells.z.length, metres = fround(step * fround(1e-6)), frictionStep = fround(0.05);
    const [z, stiffness, friction, validity] = [0, 0, 0, 0].map(() => new Float32Array(count));
    for (let i = 0; i < count; ++i) {
      if (!cells.validity[i]) continue;
      z[i] = clamp(fround(cells.z[i] * metres), -HIGHEST, HIGHEST);
      stiffness[i] = STIFFNESSES[cells.stiffness[i]];
      friction[i] = cells.friction[i] * frictionStep; // the array rounds
      validity[i] = cells.validity[i] / LARGEST_VALIDITY;
    }
    return { z, stiffness, friction, validity };
  },
};

// ---- what is felt of them

const USUAL_INTERVAL = 1 / 30; // s, of a relief that has none

/** The surface at any time: straight lines between reliefs, as gst-plugins/device/touch/relief-timeline.cpp. */
export class ReliefTrack extends PacketTrack {
  constructor() { super(new FieldDecoder(RELIEF), ['relief']); }

  knotOf(relief, due, interval) { return { time: due, lasts: interval || USUAL_INTERVAL }; }

  /** {surface, cut: another scene began since `since`, age: s since the newest relief was due, interval: s}, or null */
  at(time, since = time) {
    const around = this.around(time, since);
    if (!around) return null;
    const { from, to, cut } = around;
    const begins = to && !to.cut ? Math.max(from.time, to.comes) : Infinity;
    const isLine = time >= begins;
    const weight = isLine ? (time - begins) / Math.max(to.time - begins, 1e-9) : 0;
    return {
      surface: new Surface(from.motion, isLine ? to.motion : from.motion, Math.min(weight, 1)), cut,
      age: isLine ? 0 : time - from.time, interval: (isLine ? to : from).lasts,
    };
  }
}

/** What is felt of reliefs beside the motion: hapticsink's touch=surface+motion. */
export class Touch {
  #contact = new Contact();
  track = new ReliefTrack();

  release() { this.#contact.release(); }

  /** Where the finger touches, 0..1 from the top left, and how deep the spring is pressed, N; or null. */
  get contact() {
    const { proxy, force } = this.#contact;
    return proxy && { x: 0.5 + proxy.x / (2 * HALF), y: 0.5 - proxy.y / (2 * HALF), newtons: force.z };
  }

  /** The motion of MotionTrack.at() and the contact of a finger at `place`, for ForceChain.tick(): one ms. */
  felt(motion, time, since, place, pressed) {
    const at = this.track.at(time, since);
    const isKnown = at && at.age <= staleAfter(at.interval);
    if (!isKnown || !pressed || at.cut) this.release();
    if (!isKnown) return motion;
    if (pressed) this.#contact.step(at.surface, (place.x - 0.5) * 2 * HALF, (0.5 - place.y) * 2 * HALF);
    const isFresh = motion.measured && motion.age <= staleAfter(motion.interval);
    return {
      ...motion, cut: motion.cut || at.cut, age: at.age, interval: at.interval, measured: true, confidence: 1,
      share: isFresh ? confidenceGate(motion.confidence) : 0, push: this.#contact.force,
    };
  }
}
