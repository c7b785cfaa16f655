// SPDX-License-Identifier: LGPL-2.1-or-later
// Films that are loaded one over the other: the last one asked for is the one that is played. Then what the page that
// embeds the player allows.
import { FakeVideo, pass, waiting } from './fake-browser.mjs';
import { promise } from './promise.mjs';
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
