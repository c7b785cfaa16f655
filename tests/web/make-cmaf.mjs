// SPDX-License-Identifier: LGPL-2.1-or-later
// Cuts a fragmented MP4 at its fragments and puts the KLV sets of tracks before them, as emsg boxes:
//
//   make-cmaf.mjs FILM.mp4 FRAMES-PER-SECOND FOLDER NAME TRACK.klv...     writes NAME.m3u8 and its files
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

const [film, rate, folder, name, ...tracks] = process.argv.slice(2);
const SCALE = 90_000;

function* boxes(bytes) {
  for (let at = 0; at < bytes.length; at += bytes.readUInt32BE(at))
    yield { type: bytes.toString('latin1', at + 4, at + 8), bytes: bytes.subarray(at, at + bytes.readUInt32BE(at)) };
}

function emsg(set, time, id) {
  const names = Buffer.from('urn:misb:KLV:bin:1910.1\0\0');
  const head = Buffer.alloc(32);
  head.writeUInt32BE(head.length + names.length + set.length, 0);
  head.write('emsg', 4);
  head[8] = 1; // version
  head.writeUInt32BE(SCALE, 12);
  head.writeBigUInt64BE(BigInt(Math.round(time * SCALE)), 16);
  head.writeUInt32BE(Math.round(SCALE / rate), 24);
  head.writeUInt32BE(id, 28);
  return Buffer.concat([head, names, set]);
}

// One for each frame, of write_klv(): a key of 16 bytes, then 0x82 and two bytes of length.
function setsOf(track) {
  const klv = readFileSync(track), sets = [];
  for (let at = 0; at < klv.length; at += sets.at(-1).length) sets.push(klv.subarray(at, at + 19 + klv.readUInt16BE(at + 17)));
  return sets;
}
const all = tracks.map(setsOf);

const header = [], fragments = [];
for (const { type, bytes } of boxes(readFileSync(film)))
  if (type === 'moof') fragments.push([bytes]);
  else if (fragments.length === 0) header.push(bytes);
  else if (type === 'mdat') fragments.at(-1).push(bytes);
writeFileSync(join(folder, `${name}-header.mp4`), Buffer.concat(header));

const seconds = all[0].length / rate;
const lines = ['#EXTM3U', '#EXT-X-VERSION:7', '#EXT-X-TARGETDURATION:21', '#EXT-X-PLAYLIST-TYPE:VOD',
  `#EXT-X-MAP:URI="${name}-header.mp4"`];
const packets = all.flatMap((sets, track) => sets.map((set, i) => emsg(set, i / rate, i * all.length + track)));
writeFileSync(join(folder, `${name}-film.m4s`), Buffer.concat([...packets, ...fragments.flat()]));
lines.push(`#EXTINF:${seconds.toFixed(3)},`, `${name}-film.m4s`, '#EXT-X-ENDLIST', '');
writeFileSync(join(folder, `${name}.m3u8`), lines.join('\n'));
