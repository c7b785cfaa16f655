// SPDX-License-Identifier: MIT
// The packets of a film by their time, and the motion under the hand at any time of it: straight lines between the
// middles of the intervals that velocities were measured over, as gst-plugins/device/motion/motion-interpolator.cpp.
import { CUT, FieldDecoder, beginsPair } from './field-codec.js';
import { sampleField } from './field-sampler.js';
import { readKlv } from './klv.js';

const DUPLICATE = 2; // flag: the motion before continues
const LONGEST_RAMP = 1; // s
const FASTEST = 1e6; // px/s; faster ones are damage
const MOST_BYTES = 64 * 2 ** 20; // of packets, an hour of a lively film
const MOST_CELLS = 1e5, MOST_PACKETS = 1000; // decoded in one call; a hostile track needs several
const KEPT = 1; // s of knots behind the time that is asked for
const NOTHING = Object.freeze({ x: 0, y: 0, confidence: 0, measured: false, cut: false, age: 0, interval: 0 });

// Index of the first sorted item that is later.
function after(items, time) {
  let low = 0, high = items.length;
  while (low < high) {
    const middle = low + high >> 1;
    if (items[middle].time > time) high = middle;
    else low = middle + 1;
  }
  return low;
}

const isPlausible = field => field.x.every((x, i) => Math.hypot(x, field.y[i]) <= FASTEST);
const hasMeasurement = field => field.confidence.some(confidence => confidence > 0);

const sizeOf = ({ code, things }) => 200 + (code?.length ?? 0) + (things?.length ?? 0);
const isSame = ({ code: a }, { code: b }) => a && b && a.length === b.length && a.every((byte, i) => byte === b[i]);

/** Packets by their time, decoded around the time that is asked for. MotionTrack and ReliefTrack (touch.js) use it. */
export class PacketTrack {
  #packets = []; // {time: s, code or point, starts: whether decoding may begin here}
  #knots = []; // what was decoded, in order: see knotOf()
  #next = 0; // packet to be decoded; -1: none yet
  #first = 0; // the first one that was
  #things = null; // of the last one
  #bytes = 0; // of all packets
  #walked = { from: 0, to: -1 }; // packets between which decoding begins at `from` only
  #decoder;
  #kinds;
  /** Sets that could not be read. */
  damaged = 0;

  /** `kinds` of items of KLV. A subclass has knotOf(motion, due, sent). */
  constructor(decoder, kinds) { [this.#decoder, this.#kinds] = [decoder, kinds]; }

  get empty() { return this.#packets.length === 0; }
  get length() { return this.#packets.length; }

  /**
   * Adds the KLV sets in `bytes`, which belong to the frame at `time` (s); without it each has its own time. A packet
   * of the same time is replaced.
   * @returns whether there are reliefs among them
   */
  add(bytes, time) {
    let relief = false;
    const packets = [];
    for (const item of readKlv(bytes)) {
      const at = time ?? item.time;
      if (item.kind === 'damaged') ++this.damaged;
      if (!Number.isFinite(at)) continue;
      relief ||= item.kind === 'relief';
      if (!this.#kinds.includes(item.kind)) continue;
      const packet = { time: at, code: item.code?.slice(), things: item.things?.slice(), point: item.point };
      packet.starts = !item.code || beginsPair(item.code);
      packets.push(packet);
    }
    // In order, each goes to the end. In a file that is written backwards, all others would move for each of them.
    for (const packet of packets.sort((a, b) => a.time - b.time)) this.#insert(packet);
    return relief;
  }

  #insert(packet) {
    const at = after(this.#packets, packet.time);
    const before = this.#packets[at - 1];
    const same = Number(packet.time - before?.time < 1e-4);
    if (same && isSame(before, packet)) return;
    const grown = sizeOf(packet) - (same ? sizeOf(before) : 0);
    if (this.#bytes + grown > MOST_BYTES) return;
    this.#bytes += grown;
    this.#packets.splice(at - same, same, packet);
    if (at - same <= this.#walked.to) this.#walked = { from: 0, to: -1 };
    if (at < this.#next + same) this.#restart();
  }

  /** Drops the packets before `time` (s). */
  forgetBefore(time) {
    const count = after(this.#packets, time) - 1;
    if (count < 1000) return; // seldom, and many at once
    for (const packet of this.#packets.splice(0, count)) this.#bytes -= sizeOf(packet);
    this.#walked = { from: 0, to: -1 };
    this.#next -= count;
    if (this.#next < 0) this.#restart();
  }

  #restart() {
    this.#knots = [];
    this.#next = -1;
  }

  #decode(packet) {
    if (packet.point) return this.#addKnot(packet.point, packet.time);
    const result = this.#decoder.push(packet.code);
    if (result === 'damaged') ++this.damaged;
    if (result !== 'field') return; // the line goes on to the next one
    const { field, rest } = this.#decoder;
    if (rest) rest.things = this.#things;
    field.things = this.#things = packet.things;
    // It comes with the field. A line to the field begins then anyway where there is a motion before.
    if (rest && !this.#knots.at(-1)?.measured) this.#addKnot(rest, packet.time - field.interval / 1e6, packet.time);
    this.#addKnot(field, packet.time);
  }

  // `sent`: the time of its packet, which comes one and a half frames early.
  #addKnot(motion, due, sent = due) {
    if (motion.flags & DUPLICATE && !motion.z) return; // a surface stays
    const interval = Math.min(motion.interval / 1e6, LONGEST_RAMP);
    const knot = this.knotOf(motion, due, interval);
    motion.due = due;
    while (this.#knots.at(-1)?.time > knot.time - interval / 4) this.#knots.pop();
    this.#knots.push({ ...knot, due, comes: sent - 1.5 * interval, interval, motion, cut: (motion.flags & CUT) !== 0 });
  }

  // Decodes what is needed around `time`, or a part of it. @returns whether the knots reach from before it to behind it
  #reach(time) {
    const knots = this.#knots;
    const from = this.#start(time);
    const isPast = knots.length ? knots[0].time > time : from < this.#first;
    // A page that was busy goes through what it missed, as far as that is kept.
    if (isPast || this.#start(time - KEPT) > this.#next) {
      this.#restart();
      this.#decoder.forget();
      this.#next = this.#first = from;
    }
    const isReached = () => this.#next >= this.#packets.length || this.#knots.at(-1)?.time > time;
    const most = this.#decoder.cells + MOST_CELLS;
    for (let i = 0; i < MOST_PACKETS && this.#decoder.cells < most && !isReached(); ++i)
      this.#decode(this.#packets[this.#next++]);
    const old = after(this.#knots, time - KEPT) - 2;
    if (old > 0) this.#knots.splice(0, old);
    return isReached();
  }

  // The last packet until `time` at which decoding may begin. A hostile track has one for an hour.
  #start(time) {
    const at = Math.max(after(this.#packets, time) - 1, 0), { from, to } = this.#walked;
    const isWalked = i => from <= i && i <= to;
    let i = at;
    while (i > 0 && !this.#packets[i].starts && !isWalked(i)) --i;
    this.#walked = isWalked(i) ? { from, to: Math.max(at, to) } : { from: i, to: at };
    return this.#walked.from;
  }

  /** The knot of the frame shown at `time` (s), or undefined. */
  shownAt(time) {
    return this.#reach(time) ? this.#knots.findLast(knot => knot.due <= time + 1e-3) : undefined;
  }

  /** {from, to: the knots around `time` (s); `to` may be missing, cut: one was passed since `since`, knots: all}, or null */
  around(time, since) {
    if (this.empty || !this.#reach(time)) return null;
    const i = after(this.#knots, time) - 1;
    if (i < 0) return null;
    const cut = this.#knots.some(knot => knot.cut && knot.time > since && knot.time <= time);
    return { from: this.#knots[i], to: this.#knots[i + 1], cut, knots: this.#knots };
  }
}

export class MotionTrack extends PacketTrack {
  constructor() { super(new FieldDecoder(), ['field', 'point']); }

  // A velocity is that of the middle of its interval.
  knotOf(motion, due, interval) {
    const field = motion.columns ? motion : null;
    const measured = field ? hasMeasurement(field) && isPlausible(field)
      : motion.confidence > 0 && Math.hypot(motion.x, motion.y) <= FASTEST;
    return { time: due - interval / 2, field, measured };
  }

  /** The decoded field of the frame shown at `time` (s), or null. */
  fieldAt(time) { return this.shownAt(time)?.field ?? null; }

  /**
   * The motion at `time` (s) at `place`: {x, y: px/s, y down, confidence, measured, cut: one was passed since `since`,
   * age: s since the newest frame was due, interval: s, width: px, aspect: width of a pixel over its height}. `felt`
   * may give another knot for each; with the one that is not the next it gets all knots that there are.
   */
  at(time, place, since = time, felt = knot => knot) {
    const around = this.around(time, since);
    if (!around) return NOTHING;
    const { cut, knots } = around, from = felt(around.from, knots), to = around.to && felt(around.to);
    const begins = to ? Math.max(from.time, to.comes) : Infinity;
    const newest = time >= begins ? to : from;
    const now = {
      ...motionAt(from, place), cut, age: Math.max(time - newest.due, 0), interval: newest.interval,
      width: from.motion.width, aspect: from.motion.aspectN / from.motion.aspectD,
    };
    now.measured = from.measured && now.confidence > 0;
    if (!now.measured) return { ...now, confidence: 0 };
    if (time >= begins) interpolate(now, to, place, (time - begins) / Math.max(to.time - begins, 1e-9));
    return now;
  }
}

function motionAt(knot, place) {
  return knot.field ? sampleField(knot.field, place)
    : { x: knot.motion.x, y: knot.motion.y, confidence: knot.motion.confidence };
}

function interpolate(now, to, place, share) {
  const there = motionAt(to, place);
  if (!to.measured || !(there.confidence > 0)) return;
  const { motion } = to;
  const scaleX = now.width / motion.width; // frames may change their size
  const scaleY = scaleX * motion.aspectD / motion.aspectN * now.aspect;
  now.x += (there.x * scaleX - now.x) * share;
  now.y += (there.y * scaleY - now.y) * share;
  now.confidence += (there.confidence - now.confidence) * share;
}
