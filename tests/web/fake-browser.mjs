// SPDX-License-Identifier: LGPL-2.1-or-later
// As much of a browser as the player needs, with a clock of its own: a screen of 60 Hz and a video element whose times
// move as those of a real browser do.

let now = 0; // ms
let frames = new Map(); // that were asked for of the screen, by number
let asked = 0;
const timers = new Set();

/** Frames of the screen that are waited for, and timers that run. */
export const waiting = () => frames.size + timers.size;

Object.assign(globalThis, {
  window: new EventTarget(),
  document: Object.assign(new EventTarget(), { hidden: false, baseURI: 'http://here/' }),
  location: new URL('http://here/'),
  HTMLMediaElement: { HAVE_FUTURE_DATA: 3 },
  matchMedia: () => ({ matches: false }),
  requestAnimationFrame: callback => (frames.set(++asked, callback), asked),
  cancelAnimationFrame: number => frames.delete(number),
  setInterval: callback => (timers.add(callback), callback),
  clearInterval: callback => timers.delete(callback),
});
Object.defineProperty(globalThis, 'navigator', { value: {}, configurable: true });
performance.now = () => now;

/** A video of 30 frames a second. `step` is the time, ms, between two changes of currentTime at the present rate. */
export class FakeVideo extends EventTarget {
  currentTime = 0; // s
  duration = Infinity; // s
  paused = true;
  seeking = false;
  ended = false;
  readyState = 4;
  videoWidth = 640;
  playbackRate = 1;
  stuck = false; // nothing moves, and nobody says so
  hides = false; // time goes on, but no frame is shown
  #step;
  #time = 0; // s, that was played, over all loops
  #told = 0; // ms
  #wanted = [];
  #shown = -1; // number of the frame

  constructor(step) {
    super();
    this.#step = step;
  }
  requestVideoFrameCallback(callback) { this.#wanted.push(callback); }
  play() {
    this.paused = false;
    this.#tell('play', 'playing');
  }
  pause() {
    this.paused = true;
    this.#tell('pause');
  }
  /** Goes to a place, whose first frame is still to be shown. */
  seek(time) {
    this.seeking = true;
    this.#time = this.currentTime = time;
    this.#tell('seeking');
    this.seeking = false;
    this.#tell('seeked');
  }
  #tell(...names) {
    for (const name of names) this.dispatchEvent(new Event(name));
  }

  /** One frame of the screen. */
  refresh() {
    if (this.paused || this.stuck) return;
    this.#time += this.playbackRate / 60;
    if (now - this.#told >= this.#step) {
      this.#told = now;
      const before = this.currentTime;
      this.currentTime = Number.isFinite(this.duration) ? this.#time % this.duration : this.#time;
      if (this.currentTime < before) this.#tell('seeking', 'seeked');
    }
    const frame = Math.floor(this.#time * 30 + 1e-6);
    if (frame === this.#shown || this.hides) return;
    this.#shown = frame;
    // As in Firefox, the time of a frame goes on when a film begins again.
    for (const callback of this.#wanted.splice(0)) callback(now, { mediaTime: frame / 30, expectedDisplayTime: now });
  }
}

/** Lets `seconds` go by. */
export function pass(seconds, video) {
  for (const end = now + 1000 * seconds; now < end; now += 1000 / 60) {
    video.refresh();
    const due = frames;
    frames = new Map();
    for (const callback of due.values()) callback(now);
    for (const callback of [...timers]) callback();
  }
}

/** Lets `seconds` go by in which the film plays on, and the page is too busy for any callback. */
export function beBusy(seconds, video) {
  video.hides = true;
  for (const end = now + 1000 * seconds; now < end; now += 1000 / 60) video.refresh();
  video.hides = false;
}
