// SPDX-License-Identifier: LGPL-2.1-or-later
// Films that are loaded one over the other: the last one asked for is the one that is played. Then what the page that
// embeds the player allows.
import { FakeVideo, pass, waiting } from './fake-browser.mjs';
import { point, set, whole } from './motion-sets.mjs';
import { promise } from './promise.mjs';
import { playPlainly } from '../../pipelines/web/player/plain-hls.js';
import { Problem, attach } from '../../pipelines/web/player/player.js';

// A server that answers when it is told to.
const answers = new Map(); // by address
globalThis.fetch = url => new Promise(done => answers.set(String(url), () =>
  done({ ok: true, arrayBuffer: async () => new TextEncoder().encode('#EXTM3U\n#EXTINF:4,\nb.ts\n').buffer })));
const settle = () => new Promise(done => setTimeout(done, 10));
async function answer(address) {
  while (!answers.has(address)) await settle(); // the player loads a file of its own before
  answers.get(address)();
}

// As in a browser that plays HLS itself.
class Video extends FakeVideo {
  src = '';
  canPlayType() { return 'maybe'; }
  removeAttribute() { this.src = ''; }
  load() {}
}
const video = new Video(16), problems = [];
const player = attach(video, { rumble: false, onProblem: problem => problems.push(problem) });
const slow = player.load('slow.m3u8'), quick = player.load('quick.m3u8');
await answer('http://here/quick.m3u8');
await quick;
promise('the film that was asked for last is played', video.src === 'http://here/quick.m3u8');
answers.get('http://here/slow.m3u8')?.();
await slow;
await settle();
promise('the one before, which is late, does not take its place', video.src === 'http://here/quick.m3u8');
player.detach();
promise('detach() lets go of it', video.src === '');

// ---- films and tracks that come and go

const own = new Video(16);
answers.clear();
const replaced = attach(own, { rumble: false });
const before = replaced.load('before.m3u8');
await answer('http://here/before.m3u8');
await before;
own.src = 'http://here/after.mp4';
await replaced.loadTrack(null);
promise('a film that the page has set meanwhile stays', own.src === 'http://here/after.mp4');
replaced.detach();
promise('after detach(), too', own.src === 'http://here/after.mp4');

const codes = [], trackless = new Video(16);
const patient = attach(trackless, { rumble: false, onProblem: (_, code) => codes.push(code) });
trackless.play();
patient.loadTrack('late.klv');
pass(5, trackless);
promise('no track is missed while it is asked for', codes.length === 0);
await patient.loadTrack(null);
pass(1, trackless);
promise('a film without one says so', codes.join() === 'no-track');
patient.detach();

const odd = new Video(16);
codes.length = 0;
const broken = attach(odd, { rumble: false, onProblem: (sentence, code) => codes.push(code, sentence), hls: class {
  static isSupported() { throw new TypeError('hls.js is not well'); }
} });
await broken.load('film.m3u8');
promise('an error that nobody foresaw is told', codes[0] === 'cannot-play' && codes[1].includes('not well'));
broken.detach();

// ---- a browser whose buffer is full

const playlistOf = (names, ...tags) => ['#EXTM3U', ...tags, '#EXT-X-MAP:URI="head.mp4"',
  ...[...names].map(name => `#EXTINF:4,\n${name}.m4s`), '#EXT-X-ENDLIST', ''].join('\n');

// Segments of 4 s, one after the other, of which a buffer holds so many seconds.
function fullBrowser(most) {
  const buffer = {
    start: 0, end: 0,
    get buffered() { return { length: +(this.end > this.start), start: () => this.start, end: () => this.end }; },
    appendBuffer(bytes) {
      const seconds = bytes.length === 4 ? 4 : 0;
      if (this.end - this.start + seconds > most) throw new DOMException('full', 'QuotaExceededError');
      this.end += seconds;
      queueMicrotask(() => this.onupdateend());
    },
    remove(_, end) {
      this.start = end;
      queueMicrotask(() => this.onupdateend());
    },
  };
  globalThis.MediaSource = class extends EventTarget {
    static isTypeSupported() { return true; }
    readyState = 'open';
    addSourceBuffer() { return buffer; }
    endOfStream() { this.readyState = 'ended'; }
  };
  URL.createObjectURL = source => (queueMicrotask(() => source.dispatchEvent(new Event('sourceopen'))), 'blob:film');
  URL.revokeObjectURL = () => {};
  return buffer;
}
async function playOn(most) {
  const buffer = fullBrowser(most), video = new Video(16), ended = new AbortController(), told = [];
  const files = { 'film.m3u8': playlistOf('abcdef'), 'head.mp4': '....avcC.abc' };
  const load = async url => new TextEncoder().encode(files[url.split('/').pop()] ?? '....');
  await playPlainly(video, 'http://here/film.m3u8', { load, signal: ended.signal, onPacket() {},
    onProblem: ({ code }) => told.push(code) });
  for (; video.currentTime < 23; video.currentTime += 0.5) {
    await settle();
    video.dispatchEvent(new Event('timeupdate'));
  }
  await settle();
  ended.abort();
  return { end: buffer.end, told };
}
const filled = await playOn(10);
promise('what was played makes room for the rest', filled.end === 24 && filled.told.length === 0);
const small = await playOn(3);
promise('a segment that never fits is told, once', small.end === 0 && new Set(small.told).size === 1
  && small.told[0] === 'part-large');

// ---- seeks, where a film begins, and a network that was away

// A buffer that holds all segments, each at its place: 'c.m4s' from 8 s on.
function roomyBrowser() {
  const buffer = fullBrowser(Infinity), there = new Set();
  Object.defineProperty(buffer, 'buffered', { get() {
    const starts = [...there].sort((a, b) => a - b);
    const ranges = [];
    for (const start of starts)
      if (ranges.at(-1)?.[1] === start) ranges.at(-1)[1] = start + 4;
      else ranges.push([start, start + 4]);
    return { length: ranges.length, start: i => ranges[i][0], end: i => ranges[i][1] };
  } });
  buffer.appendBuffer = bytes => {
    if (bytes.length === 1) there.add(4 * (bytes[0] - 'a'.charCodeAt(0)));
    queueMicrotask(() => buffer.onupdateend());
  };
  return buffer;
}
const LONG = 'abcdefghijklmnopqrstuvwxyz';
async function playAt(tags, use) {
  roomyBrowser();
  const film = new Video(16), ended = new AbortController(), asked = [];
  let isThere = true;
  const load = async url => {
    const name = url.split('/').pop();
    if (!isThere) throw new Problem('part-missing');
    if (name.endsWith('m4s')) asked.push(name[0]);
    return new TextEncoder().encode({ 'film.m3u8': playlistOf(LONG, ...tags), 'head.mp4': '....avcC.abc' }[name] ?? name[0]);
  };
  await playPlainly(film, 'http://here/film.m3u8', { load, signal: ended.signal, onPacket() {}, onProblem() {} });
  await settle();
  await use(film, asked, there => { isThere = there; });
  ended.abort();
}
const seekTo = async (film, time) => {
  film.seek(time);
  await settle();
};
await playAt([], async (film, asked) => {
  for (const [time, name] of [[79.9, 't'], [47.86, 'l'], [50, 'm']]) {
    await seekTo(film, time);
    promise(`a seek to ${time} s asks for the segment of that time`, asked.includes(name));
  }
  promise('and for none twice', new Set(asked).size === asked.length || console.log(asked.join('')));
});
await playAt(['#EXT-X-START:TIME-OFFSET=0.500000,PRECISE=YES'], film => {
  promise('a film begins where its playlist says', film.currentTime === 0.5);
});
await playAt([], async (film, asked, setThere) => {
  setThere(false);
  await seekTo(film, 81);
  setThere(true);
  promise('without a network nothing comes', !asked.includes('u'));
  window.dispatchEvent(new Event('online'));
  await settle();
  promise('until it is there again', asked.includes('u'));
});

// As much of hls.js as is needed.
class FakeHls {
  static Events = { ERROR: 'error', FRAG_BUFFERED: 'buffered', FRAG_PARSING_METADATA: 'metadata' };
  static ErrorTypes = { MEDIA_ERROR: 'media', NETWORK_ERROR: 'network' };
  static isSupported() { return true; }
  config = {};
  loads = [];
  recoveries = 0;
  #listeners = {};
  constructor() { FakeHls.last = this; }
  on(event, listener) { this.#listeners[event] = listener; }
  emit(event, data) { this.#listeners[event]?.(event, data); }
  loadSource() {}
  attachMedia() {}
  detachMedia() {}
  destroy() {}
  off() {}
  startLoad(time) { this.loads.push(time); }
  recoverMediaError() { ++this.recoveries; }
}
const cut = new Video(16);
const withHls = attach(cut, { playlist: 'film.m3u8', hls: FakeHls, rumble: false });
await settle();
const hls = FakeHls.last;
cut.seek(3);
promise('a seek alone starts no load', hls.loads.length === 0);
hls.emit('error', { fatal: true, type: 'network', details: 'fragLoadError' });
cut.seek(5);
cut.seek(7);
hls.emit('error', { fatal: true, type: 'network', details: 'fragLoadError' });
window.dispatchEvent(new Event('online'));
promise('hls.js that gave up loads again after a seek or when the network comes', hls.loads.join() === '5,7');
for (let hour = 0; hour < 8; ++hour) {
  hls.emit('error', { fatal: true, type: 'media', details: 'bufferAppendError' });
  hls.emit('buffered');
}
promise('each hour may have its damage', hls.recoveries === 8);
for (let time = 0; time < 4; ++time) hls.emit('error', { fatal: true, type: 'media', details: 'bufferAppendError' });
promise('damage that stays is given up', hls.recoveries === 11);
withHls.detach();

// ---- packets that come once

const once = new Video(16);
once.buffered = { length: 1, start: () => 0, end: () => 400 };
const fed = attach(once, { rumble: false });
fed.place = { x: 0.5, y: 0.5 };
for (let frame = 0; frame < 7500; ++frame) {
  once.currentTime = frame * 0.04;
  fed.addPacket(point(300), once.currentTime);
}
once.seek(10);
once.play();
pass(1, once);
promise('what the browser keeps of a film is felt after a seek back', fed.force.x > 0.5);
fed.detach();

const damaged = new Video(16), damages = [];
const fields = attach(damaged, { rumble: false, onProblem: (_, code) => damages.push(code) });
fields.place = { x: 0.5, y: 0.5 };
fields.addPacket(set([[1, [1]], [2, [1]], [3, [...whole(0), ...whole(2e8)]], [32, [5, 1, 2, 3]]]));
promise('a set that is whole says nothing', damages.length === 0);
damaged.play();
pass(1, damaged);
promise('damage in it is told when it is decoded', damages.join() === 'track-damaged');
fields.detach();

// ---- what the page that embeds the player allows, and says in its own words

const told = [];
const onProblem = (sentence, code) => told.push({ sentence, code });
const settled = async condition => {
  for (let i = 0; i < 500 && !condition(); ++i) await settle();
};
const ELSEWHERE = 'http://films.example/film.klv';
answers.clear();
attach(new Video(16), { track: ELSEWHERE, onProblem });
attach(new Video(16), { track: ELSEWHERE, onProblem, texts: { 'origin-refused': 'Nicht von {host}.' } });
await settled(() => told.length === 2);
promise('a track of another origin is refused, and not asked for', told.every(({ code }) => code === 'origin-refused')
  && answers.size === 0);
promise('in the words of the page, if it has some', told[0].sentence.includes('films.example')
  && told[1].sentence === 'Nicht von films.example.');
attach(new Video(16), { track: ELSEWHERE, onProblem, allowedOrigins: ['http://films.example'] });
await settled(() => answers.has(ELSEWHERE));
promise('an origin that the page allows is asked', answers.has(ELSEWHERE) && told.length === 2);

const ended = new AbortController(), ending = new Video(16);
ending.src = 'http://here/film.m3u8';
const followed = attach(ending, { signal: ended.signal });
ending.play();
pass(0.1, ending);
promise('a player follows its film', waiting() === 1);
ended.abort();
pass(0.1, ending);
promise('until its signal is aborted', waiting() === 0 && followed.force.x === 0);
attach(ending, { signal: ended.signal });
pass(0.1, ending);
promise('one that begins afterwards never does', waiting() === 0);

globalThis.fetch = async () => ({ ok: true, headers: new Headers({ 'content-length': 8 * 2 ** 20 + 1 }) });
told.length = 0;
attach(new Video(16), { track: 'film.klv', onProblem });
await settled(() => told.length > 0);
promise('a track of more than 8 MB is refused', told[0].code === 'track-large');
