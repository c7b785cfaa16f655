// SPDX-License-Identifier: LGPL-2.1-or-later
import Hls from './player/hls.light.min.js';
import { attach } from './player/player.js';

const AHEAD = 0.008; // s; the hand is where it will be at the middle of the next frame of the screen
const film = document.getElementById('film');
const forces = [];
const GAP = 100; // ms without a frame of the film or of the screen, which other work on the machine causes
window.gaps = []; // s of the film, at the end of each

function watch(ask, timeOf) {
  let last = performance.now();
  const next = (now, frame) => {
    if (now - last > GAP) window.gaps.push(timeOf(frame));
    last = now;
    ask(next);
  };
  ask(next);
}

/** `hands`: [s of the film from its first frame, place], in order. */
window.follow = hands => {
  const place = time => hands[Math.max(hands.findIndex(([at]) => at >= time), 0)][1];
  const player = attach(film, {
    playlist: 'sink.m3u8', hls: Hls, alpha: 0.04,
    onForce: ({ time, x, y }) => { if (time !== null) forces.push({ time, x, y }); },
  });
  film.addEventListener('loadeddata', () => {
    window.begin = film.buffered.start(0);
    watch(next => requestAnimationFrame(next), () => film.currentTime);
    watch(next => film.requestVideoFrameCallback(next), ({ mediaTime }) => mediaTime);
    film.play();
  });
  setInterval(() => { player.place = place(film.currentTime - (window.begin ?? 0) + AHEAD); }, 4);
  film.addEventListener('ended', () => { window.forces = forces; });
};
