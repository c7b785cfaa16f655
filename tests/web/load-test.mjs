// SPDX-License-Identifier: LGPL-2.1-or-later
// Films that are loaded one over the other: the last one asked for is the one that is played. Then what the page that
// embeds the player allows.
import { FakeVideo, pass, waiting } from './fake-browser.mjs';
import { promise } from './promise.mjs';
import { playPlainly } from '../../pipelines/web/player/plain-hls.js';
import { attach } from '../../pipelines/web/player/player.js';

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
  const files = { 'film.m3u8': '#EXTM3U\n#EXT-X-MAP:URI="head.mp4"\n' +
    [...'abcdef'].map(name => `#EXTINF:4,\n${name}.m4s\n`).join(''), 'head.mp4': '....avcC.abc' };
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
