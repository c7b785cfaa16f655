// SPDX-License-Identifier: LGPL-2.1-or-later
// Packets that come in any order, tracks of points, and limits of what a track or a caller may ask for.
import { FieldDecoder } from '../../pipelines/web/player/field-codec.js';
import { load } from '../../pipelines/web/player/film.js';
import { MotionTrack } from '../../pipelines/web/player/motion-track.js';
import { magnitudes } from '../../pipelines/web/player/rumble.js';
import { mediaType, readPackets, readPlaylist } from '../../pipelines/web/player/plain-hls.js';
import { point, set, whole } from './motion-sets.mjs';
import { promise } from './promise.mjs';

const HERE = { x: 0.5, y: 0.5 };

const track = new MotionTrack();
for (const frame of [2, 0, 3, 1]) track.add(point(100 * frame, [21, whole(0, 1)]), frame * 0.04);
promise('packets may come in any order, with values of a later version', track.length === 4 && track.damaged === 0);
promise('a point is felt everywhere, between two on the line', Math.abs(track.at(0.08, HERE).x - 250) < 1e-3
  && track.at(0.02, { x: 0, y: 1 }).x === 100);
track.add(point(500), 0.08);
promise('a packet that comes again replaces the old one', track.length === 4 && track.at(0.06, HERE).x === 500);
track.add(Uint8Array.from([1, 2, 3]), 0.2);
promise('what is no KLV is counted and left out', track.damaged === 1 && track.length === 4);
promise('a time that is no number is left out', (track.add(point(1), NaN), track.length === 4));

const long = new MotionTrack();
for (let frame = 0; frame < 5000; ++frame) long.add(point(frame % 100), frame * 0.04);
long.forgetBefore(100);
promise('what is long past is forgotten', long.length > 2400 && long.length < 2600 && long.at(150.02, HERE).measured);

const huge = new FieldDecoder();
const number = value => value < 0x80 ? [value] : [value & 0x7F | 0x80, ...number(value >> 7)];
const key = (columns, rows, head = 5, ...scale) =>
  Uint8Array.from([head, 1, ...[40_000, ...scale, columns, rows, 352, 288, 1, 1].flatMap(number), 0, 0]);
promise('a field larger than the limit is refused', huge.push(key(8192, 2)) === 'damaged'
  && huge.push(key(9000, 1)) === 'damaged' && huge.field === null);

// Fields of the largest size, at none of which decoding may begin: a seek behind them.
const hostile = new MotionTrack();
const fields = 40, cells = 128 * 64;
for (let frame = 0; frame < fields; ++frame)
  hostile.add(set([[1, [1]], [2, [1]], [32, key(128, 64, 13, 40_000)]]), frame * 0.04);
const { push } = FieldDecoder.prototype;
let decoded = 0;
FieldDecoder.prototype.push = function (code) {
  const before = this.cells, result = push.call(this, code);
  decoded += this.cells - before;
  return result;
};
const work = Array.from({ length: 6 }, () => {
  const before = decoded;
  hostile.at(fields * 0.04, HERE);
  return decoded - before;
});
FieldDecoder.prototype.push = push;
console.log(`cells in a call: ${work}`);
promise('a seek in a hostile track does a little in each call', Math.max(...work) <= 1e5 + cells && work[1] > 0);
promise('and ends', decoded === fields * cells && work.at(-1) === 0);

// Many packets, at none of which decoding may begin, from the last to the first.
const many = 5000, backwards = [];
for (let frame = many; frame > 0; --frame)
  backwards.push(...set([[1, [1]], [2, [1]], [3, [...whole(0), ...whole(1e5 * frame * 2)]], [32, key(2, 2, 13, 40_000)]]));
const { splice } = Array.prototype;
let moved = 0, looked = 0;
Array.prototype.splice = function (at, ...rest) {
  moved += this.length - at;
  return splice.call(this, at, ...rest);
};
Object.defineProperty(Object.prototype, 'starts', { configurable: true, set(starts) {
  Object.defineProperty(this, 'starts', { get: () => (++looked, starts) });
} });
const turned = new MotionTrack();
turned.add(Uint8Array.from(backwards));
promise('a track that is written backwards is put in order at once', turned.length === many && moved < many);
for (let tick = 0; tick < 100; ++tick) turned.at(1 + tick / 1000, HERE);
Array.prototype.splice = splice;
delete Object.prototype.starts;
console.log(`${looked} packets were asked whether decoding may begin there`);
promise('and where decoding begins is not looked for in each tick', looked > 0 && looked < 4 * many);

// A server that fails, and one that has no such file.
Object.assign(globalThis, { location: { origin: 'http://here' }, setTimeout: done => queueMicrotask(done) });
const answers = [null, { status: 503 }, { ok: true, arrayBuffer: async () => { throw new Error('cut'); } },
  { ok: true, arrayBuffer: async () => new ArrayBuffer(3) }];
let asked = 0;
globalThis.fetch = async () => answers[asked++] ?? Promise.reject(new Error('no network'));
promise('a segment is asked for again after a failure', (await load('http://here/1.mp4')).length === 3 && asked === 4);
const failure = await load('http://here/1.mp4').catch(error => error.message);
promise('but not for ever', failure === 'A part of the film cannot be loaded. Check the server.' && asked === 9);
globalThis.fetch = async () => (++asked, { status: 404 });
promise('one that is not there is asked for once', /404/.test(await load('http://here/1.mp4').catch(error => error.message))
  && asked === 10);

const full = { strongMagnitude: 1, weakMagnitude: 1 }, none = { strongMagnitude: 0, weakMagnitude: 0 };
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
promise('no force is more than full', same(magnitudes(50, 1, 1), full) && same(magnitudes(Infinity, 1, 1), full));
promise('nothing is felt of what is no number, or too weak', same(magnitudes(NaN, 1, 1), none)
  && same(magnitudes(0.01, 1, 1), none));
promise('half the force is half of the one motor and a quarter of the other',
  same(magnitudes(0.5, 1, 1), { strongMagnitude: 0.25, weakMagnitude: 0.5 }));

// Damaged segments, always the same ones: nothing is thrown, and no packet reaches beyond its box.
let state = 1;
const random = limit => (state = Math.imul(state, 1664525) + 1013904223 >>> 0) % limit;
const SCHEME = Array.from('urn:misb:KLV:bin:1910.1\0\0', letter => letter.charCodeAt(0));
const box = content => [...whole(content.length + 8), ...[0x65, 0x6D, 0x73, 0x67], ...content]; // emsg
const newer = box([1, 0, 0, 0, ...whole(90_000, 0, 45_000, 3000, 1), ...SCHEME, 1, 2, 3]);
const older = box([0, 0, 0, 0, ...SCHEME, ...whole(1000, 250, 40, 2), 4, 5]);
const segment = Uint8Array.from([...newer, ...older]);
const packets = [...readPackets(segment, 10)].map(({ time, bytes }) => [time, ...bytes]);
promise('both kinds of emsg are read', JSON.stringify(packets) === '[[0.5,1,2,3],[10.25,4,5]]');
for (let i = 0; i < 20_000; ++i) {
  const damaged = segment.slice(0, 1 + random(segment.length));
  for (let times = random(5); times > 0; --times) damaged[random(damaged.length)] = random(256);
  for (const { bytes } of readPackets(damaged, 0)) if (bytes.length > damaged.length) promise('a packet of its box', false);
  mediaType(damaged);
}
promise('damaged segments are read without an error', true);
const PLAIN = '#EXTM3U\n#EXT-X-MAP:URI="a.mp4"\n#EXTINF:4,\nb.m4s\n#EXTINF:2.5,\nc.m4s\n#EXT-X-ENDLIST\n';
const list = readPlaylist(PLAIN, 'http://here/film/x.m3u8');
promise('a plain playlist is read', list.map === 'http://here/film/a.mp4' && list.segments[1].start === 4
  && list.segments[1].url === 'http://here/film/c.m4s' && list.from === 0);
promise('and where its film begins', readPlaylist(
  PLAIN.replace('#EXT-X-MAP', '#EXT-X-START:TIME-OFFSET=0.500000,PRECISE=YES\n#EXT-X-MAP'), 'http://here/').from === 0.5);
for (const [what, text] of [
  ['that is encrypted', PLAIN.replace('#EXTINF', '#EXT-X-KEY:METHOD=AES-128,URI="k"\n#EXTINF')],
  ['that is not CMAF', '#EXTM3U\n#EXTINF:4,\nb.ts\n#EXT-X-ENDLIST\n'],
  ['that goes on', PLAIN.replace('#EXT-X-ENDLIST\n', '')],
  ['of two films', PLAIN.replace('#EXTINF:2.5', '#EXT-X-DISCONTINUITY\n#EXTINF:2.5')],
  ['with a second header', PLAIN.replace('#EXTINF:2.5', '#EXT-X-MAP:URI="d.mp4"\n#EXTINF:2.5')],
  ['with sound of its own', '#EXTM3U\n#EXT-X-MEDIA:TYPE=AUDIO,GROUP-ID="a",URI="a.m3u8"\n#EXT-X-STREAM-INF:AUDIO="a"\nb.m3u8\n'],
  ['that is none', '<html>'],
]) promise(`a playlist ${what} is left to hls.js`, readPlaylist(text, 'http://here/') === null);
