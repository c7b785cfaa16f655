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
  const value = items.flatMap(([tag, bytes]) => [tag, bytes.length, ...bytes]);
  return Uint8Array.from([...KEY, 0x82, value.length >> 8, value.length & 0xFF, ...value]);
};

/** A point that moves at `speed` px/s to the right in a frame 352 px wide, 25 of them a second. */
export const point = (speed, ...further) => set([[1, [1]], [2, [0]], [5, [0, 0]], [6, [...whole(0), ...whole(40_000_000)]],
  [7, floats(speed, 0)], [8, floats(0)], [9, floats(0)], [10, floats(0.5, 0.5)], [11, floats(0.1, 0.1)], [12, floats(1)],
  [13, whole(352, 288)], [14, whole(1, 1)], [15, [0, 1]], [16, [2]], ...further]);
