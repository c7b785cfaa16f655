// SPDX-License-Identifier: LGPL-2.1-or-later
import Hls from './player/hls.light.min.js';
import { attach } from './player/player.js';

const AHEAD = 0.008; // s; the hand is where it will be at the middle of the next frame of the screen
const film = document.getElementById('film');
const forces = [];

/** `hands`: [s of the film from its first frame, place], in order. */
window.follow = hands => {
  const place = time => hands[Math.max(hands.findIndex(([at]) => at >= time), 0)][1];
  const player = attach(film, {
    playlist: 'sink.m3u8', hls: Hls, alpha: 0.04,
    onForce: ({ time, x, y }) => { if (time !== null) forces.push({ time, x, y }); },
  });
  film.addEventListener('loadeddata', () => {
    window.begin = film.buffered.start(0);
    film.play();
  });
  setInterval(() => { player.place = place(film.currentTime - (window.begin ?? 0) + AHEAD); }, 4);
  film.addEventListener('ended', () => { window.forces = forces; });
};
