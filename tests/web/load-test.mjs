// SPDX-License-Identifier: LGPL-2.1-or-later
// Films that are loaded one over the other: the last one asked for is the one that is played.
import { FakeVideo } from './fake-browser.mjs';
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
