// SPDX-License-Identifier: MIT
// Reader of motion sets (docs/formats/klv.md), equal to gst-plugins/track/forms/klv.cpp.

const DESIGNATOR = [0x06, 0x0E, 0x2B, 0x34];
const MOTION_KEY = [...DESIGNATOR, 0x02, 0x0B, 0x01, 0x01, 0x0F, 0x48, 0x41, 0x50, 0x54, 0x49, 0x43, 0x01];
const VERSION = 1, POINT = 0, FIELD = 1, RELIEF = 2;
const T = {
  version: 1, kind: 2, time: 3, duration: 4, flags: 5, interval: 6, velocity: 7, spin: 8, divergence: 9, pointer: 10,
  region: 11, confidence: 12, frame: 13, pixelAspect: 14, points: 15, model: 16, held: 17, heldPlace: 18,
  heldRadius: 19, heldTime: 20, field: 32, relief: 33, things: 34,
};
const TAGS = 35;
// Tag and bytes of each value of a point; of a field the first two may be there.
const SIZES = [[T.time, 8], [T.duration, 8], [T.flags, 2], [T.interval, 8], [T.velocity, 8], [T.spin, 4],
  [T.divergence, 4], [T.pointer, 8], [T.region, 8], [T.confidence, 4], [T.frame, 8], [T.pixelAspect, 8], [T.points, 2],
  [T.model, 1], [T.held, 1], [T.heldPlace, 8], [T.heldRadius, 4], [T.heldTime, 8]];
const HELD = [T.held, T.heldPlace, T.heldRadius, T.heldTime]; // the last three are needed with the first
const OPTIONAL = [T.time, T.duration, ...HELD];
const LAST_MODEL = 4; // affine
const LAST_STATE = 5; // refused
const MOST_THINGS = 32;

// Reads a BER length at `at`. Returns it and where the value begins, or null.
function readLength(bytes, at) {
  if (at >= bytes.length) return null;
  let length = bytes[at++];
  if (length >= 0x80) {
    const count = length & 0x7F;
    if (count === 0 || count > 8 || count > bytes.length - at) return null;
    length = 0;
    for (let i = 0; i < count; ++i) length = length * 256 + bytes[at++];
  }
  return length > bytes.length - at ? null : { length, at };
}

const damaged = (error, offset) => ({ kind: 'damaged', error, offset });

// Returns the values by their tags, and where each begins; or what is wrong.
function readSet(bytes) {
  const values = [], offsets = [];
  for (let at = 0; at < bytes.length;) {
    const start = at;
    const first = bytes[at++];
    // A tag of several bytes belongs to a later version.
    while (at < bytes.length && bytes[at - 1] & 0x80) ++at;
    const tag = first & 0x80 ? 0 : first;
    const found = readLength(bytes, at);
    if (!found) return damaged('a length leads beyond the end of the set', start);
    at = found.at + found.length;
    if (tag === 0 || tag >= TAGS) continue;
    if (values[tag]) return damaged('a tag is there twice', start);
    values[tag] = bytes.subarray(found.at, at);
    offsets[tag] = found.at;
  }
  return { values, offsets };
}

const u64 = value => new DataView(value.buffer, value.byteOffset, value.length).getBigUint64(0);

function pointOf(values) {
  const view = tag => new DataView(values[tag].buffer, values[tag].byteOffset, values[tag].length);
  const f32 = (tag, at = 0) => view(tag).getFloat32(at);
  const u32 = (tag, at = 0) => view(tag).getUint32(at);
  return {
    flags: view(T.flags).getUint16(0), interval: Number(u64(values[T.interval])) / 1000, // µs
    x: f32(T.velocity), y: f32(T.velocity, 4), spin: f32(T.spin), divergence: f32(T.divergence),
    pointerX: f32(T.pointer), pointerY: f32(T.pointer, 4), regionWidth: f32(T.region), regionHeight: f32(T.region, 4),
    confidence: f32(T.confidence), width: u32(T.frame), height: u32(T.frame, 4), aspectN: u32(T.pixelAspect),
    aspectD: u32(T.pixelAspect, 4), points: view(T.points).getUint16(0), model: values[T.model][0],
    held: values[T.held] && { state: values[T.held][0], x: f32(T.heldPlace), y: f32(T.heldPlace, 4),
      radius: f32(T.heldRadius), time: Number(u64(values[T.heldTime])) / 1e9 }, // s
  };
}

const isFraction = value => value >= 0 && value <= 1;

function isValid(p) {
  return [p.x, p.y, p.spin, p.divergence].every(Number.isFinite) &&
    [p.pointerX, p.pointerY, p.regionWidth, p.regionHeight, p.confidence].every(isFraction) &&
    [p.width, p.height, p.aspectN, p.aspectD].every(n => n > 0) && p.model <= LAST_MODEL &&
    (!p.held || p.held.state <= LAST_STATE && [p.held.x, p.held.y, p.held.radius].every(isFraction));
}

// Of a field: their number, three zeros, and twelve bytes each, the third of which is the state (field-hold.js).
function areThings(bytes) {
  const end = 4 + 12 * bytes[0];
  return bytes[0] <= MOST_THINGS && bytes.length >= Math.max(end, 4) &&
    bytes.subarray(0, end).every((state, i) => i < 4 || i % 12 !== 6 || state > 0 && state < 4);
}

function readMotion(bytes, offset) {
  const { values, offsets, ...wrong } = readSet(bytes);
  if (wrong.error) return damaged(wrong.error, offset + wrong.offset);
  if (values[T.version]?.length !== 1 || values[T.kind]?.length !== 1)
    return damaged('the version or the kind is missing', offset);
  if (values[T.version][0] !== VERSION) return { kind: 'other version', offset };
  const kind = values[T.kind][0];
  if (kind > RELIEF) return { kind: 'other kind', offset };
  for (const [tag, size] of SIZES) {
    const needed = kind === POINT && (!OPTIONAL.includes(tag) || values[T.held] && HELD.includes(tag));
    if (!values[tag] && needed) return damaged('a value is missing', offset);
    if (values[tag] && values[tag].length !== size)
      return damaged('a value has the wrong size', offset + offsets[tag]);
  }
  const time = values[T.time] && Number(u64(values[T.time])) / 1e9; // s
  if (kind !== POINT) {
    const code = values[kind === FIELD ? T.field : T.relief];
    if (!code?.length) return damaged('a value is missing', offset);
    const things = kind === FIELD ? values[T.things] : undefined;
    if (things?.length && !areThings(things)) return damaged('a value is out of its range', offset + offsets[T.things]);
    return { kind: kind === FIELD ? 'field' : 'relief', offset, time, code, things };
  }
  const point = pointOf(values);
  return isValid(point) ? { kind: 'point', offset, time, point } : damaged('a value is out of its range', offset);
}

const startsWith = (bytes, at, start) => start.every((byte, i) => bytes[at + i] === byte);

function findKey(bytes, at) {
  while (at < bytes.length && !startsWith(bytes, at, MOTION_KEY)) ++at;
  return at;
}

// Yields {kind, offset} with `point`, `code` (of a field or relief) or `error`, and `time` (s) if the set has one.
// Kinds: point, field, relief, foreign, other version, other kind, damaged.
export function* readKlv(bytes) {
  for (let at = 0; at < bytes.length;) {
    const start = at;
    const isKey = bytes.length - at >= MOTION_KEY.length && startsWith(bytes, at, DESIGNATOR);
    const found = isKey ? readLength(bytes, at + MOTION_KEY.length) : null;
    if (!found) {
      at = findKey(bytes, start + 1);
      yield damaged(isKey ? 'a triplet is cut off' : 'this is not KLV', start);
      continue;
    }
    at = found.at + found.length;
    if (startsWith(bytes, start, MOTION_KEY)) yield readMotion(bytes.subarray(found.at, at), found.at);
    else yield { kind: 'foreign', offset: start };
  }
}
