// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion sets of KLV (docs/formats/klv.md) for the tests of the player.

const KEY = [0x06, 0x0E, 0x2B, 0x34, 0x02, 0x0B, 0x01, 0x01, 0x0F, 0x48, 0x41, 0x50, 0x54, 0x49, 0x43, 0x01];

function bytesOf(size, write) {
  const bytes = new Uint8Array(size);
  write(new DataView(bytes.buffer));
  return Array.from(bytes);
}
const floats = (...values) => bytesOf(4 * values.length, view => {
  for (const [i, value] of values.entries()) view.setFloat32(4 * i, value);
});
export const whole = (...values) => bytesOf(4 * values.length, view => {
  for (const [i, value] of values.entries()) view.setUint32(4 * i, value);
});
export const set = items => {
  const lengthOf = ({ length }) => length < 0x80 ? [length] : [0x82, length >> 8, length & 0xFF];
  const value = items.flatMap(([tag, bytes]) => [tag, ...lengthOf(bytes), ...bytes]);
  return Uint8Array.from([...KEY, ...lengthOf(value), ...value]);
};

/** A point that moves at `speed` px/s to the right in a frame 352 px wide, 25 of them a second. */
export const point = (speed, ...further) => set([[1, [1]], [2, [0]], [5, [0, 0]], [6, [...whole(0), ...whole(40_000_000)]],
  [7, floats(speed, 0)], [8, floats(0)], [9, floats(0)], [10, floats(0.5, 0.5)], [11, floats(0.1, 0.1)], [12, floats(1)],
  [13, whole(352, 288)], [14, whole(1, 1)], [15, [0, 1]], [16, [2]], ...further]);

const STATES = { held: 1, about: 2, hidden: 3 };
/** The things of a field as its packed form has them: {id, state, x, y, radius}, in fractions of the frame. */
export const packedThings = things => bytesOf(4 + 12 * things.length, view => {
  view.setUint8(0, things.length);
  for (const [i, { id, state = 'held', x, y, radius = 0.02 }] of things.entries()) {
    view.setUint16(4 + 12 * i, id, true);
    view.setUint8(6 + 12 * i, STATES[state] ?? state);
    for (const [j, value] of [x, y, radius].entries()) view.setUint16(8 + 12 * i + 2 * j, Math.round(65535 * value), true);
  }
});

const number = value => value < 0x80 ? [value] : [value & 0x7F | 0x80, ...number(value >> 7)];
/** The code of a key field of 4 cells in a frame 1920 x 1080 in which nothing was measured, 25 of them a second. */
export function emptyField(flags = 0) {
  const head = 5 | flags << 4, interval = 40_000;
  let hash = 2166136261; // docs/formats/field-code.md
  for (const value of [head, 1, interval, ...Array(12).fill(0)]) hash = Math.imul(hash ^ value, 16777619);
  const check = (hash ^ hash >>> 16) & 0xFFFF;
  return [head, 1, ...[interval, 2, 2, 1920, 1080, 1, 1].flatMap(number), check & 0xFF, check >> 8];
}

/** A field with things. */
export const fieldWith = (things, flags) => set([[1, [1]], [2, [1]], [32, emptyField(flags)], [34, packedThings(things)]]);
