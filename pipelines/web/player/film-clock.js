// SPDX-License-Identifier: MIT
// The time of the frame on the screen. The element's currentTime is too coarse for it: in Firefox it moves in steps of
// 34 ms, of 83 ms at half the speed.

const SHORTEST_STALL = 120; // ms
const STALLED_FRAMES = 3; // intervals without a frame
const LONGEST_INTERVAL = 1; // s

export class FilmClock {
  #video;
  #frame = null; // {time: s of the film, shown: ms} of the last frame
  #interval = 0; // s of the film, between the last two frames

  constructor(video) { this.#video = video; }

  /** Another place of the film: the last frame says nothing any more. */
  begin() { this.#frame = null; }

  /** A frame with the time `mediaTime` (s) was shown at `shown` (ms of performance.now()). */
  frame(mediaTime, shown) {
    // In Firefox the time of a frame goes on when a film in a loop begins again.
    const { currentTime, duration } = this.#video;
    const rounds = duration > 0 ? Math.round((mediaTime - currentTime) / duration) : 0;
    const time = rounds ? mediaTime - rounds * duration : mediaTime;
    const interval = time - this.#frame?.time;
    if (interval > 0) this.#interval = Math.min(interval, LONGEST_INTERVAL);
    this.#frame = { time, shown };
  }

  /** Takes currentTime for the time of a frame, where the browser says nothing of frames. */
  look(now) {
    const { currentTime } = this.#video;
    if (currentTime !== this.#frame?.time) this.frame(currentTime, now);
  }

  /** s of the film at `now` (ms) */
  at(now) {
    if (!this.#frame) return this.#video.currentTime;
    const since = Math.max(now - this.#frame.shown, 0) / 1000;
    return this.#frame.time + (this.#video.paused ? 0 : since * this.#video.playbackRate);
  }

  /** Whether no frame came for so long that the film stands still. */
  stalls(now) {
    const interval = 1000 * this.#interval / this.#video.playbackRate;
    return !this.#frame || now - this.#frame.shown > Math.max(STALLED_FRAMES * interval, SHORTEST_STALL);
  }
}
