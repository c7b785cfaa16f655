// SPDX-License-Identifier: LGPL-2.1-or-later
import Hls from './player/hls.light.min.js';
import { attach } from './player/player.js';

const video = document.getElementById('film');
let shown = 0; // s, the picture on the screen
const onFrame = (_, { mediaTime }) => {
  shown = mediaTime;
  video.requestVideoFrameCallback(onFrame);
};
video.requestVideoFrameCallback(onFrame);
window.lags = []; // ms
window.strongest = 0;

const player = attach(video, {
  playlist: 'film.m3u8', hls: Hls, alpha: 0.04,
  onForce({ newtons, time }) {
    if (newtons > 0) window.lags.push(Math.abs(time - shown) * 1000);
    window.strongest = Math.max(window.strongest, newtons);
  },
});
player.place = { x: 0.42, y: 0.42 };
video.play();
