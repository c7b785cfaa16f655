// SPDX-License-Identifier: LGPL-2.1-or-later
// Adds a thing to each field of a track, as `haptic-track author` adds those that it followed:
//
//   add-things.mjs TRACK.klv FRAMES-PER-SECOND OUT.klv
import { readFileSync, writeFileSync } from 'node:fs';
import { packedThings } from './motion-sets.mjs';

const [input, rate, output] = process.argv.slice(2);
const HEAD = 19; // bytes, of write_klv(): a key of 16 bytes, then 0x82 and two bytes of length

// It swings about the tree, is hidden from 6 to 8.5 s, and gone from 12 s on.
const thingsAt = time => time >= 12 ? [] : [{
  id: 1, state: time >= 6 && time < 8.5 ? 'hidden' : 'held', x: 0.42 + 0.04 * Math.sin(2 * Math.PI * time / 2), y: 0.42, radius: 0.04,
}];

const track = readFileSync(input), sets = [];
for (let at = 0, i = 0, size; at < track.length; at += HEAD + size, ++i) {
  size = track.readUInt16BE(at + 17);
  const things = packedThings(thingsAt(i / rate));
  const set = Buffer.concat([track.subarray(at, at + HEAD + size), Buffer.from([34, things.length, ...things])]);
  set.writeUInt16BE(set.length - HEAD, 17);
  sets.push(set);
}
writeFileSync(output, Buffer.concat(sets));
