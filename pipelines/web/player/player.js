// SPDX-License-Identifier: LGPL-2.1-or-later
// The player without a page: attach() lets a hand feel the film in a video element (docs/web.md, "Embed it").
import { FilmClock } from './film-clock.js';
import { forgottenBefore, playFilm, playlistAddress } from './film.js';
import { ForceChain } from './force-chain.js';
import { MotionTrack } from './motion-track.js';
import { Rumble, magnitudes, rumblePads } from './rumble.js';

export { Refusal } from './film.js';

const STOPS = ['pause', 'seeking', 'ended', 'waiting', 'emptied', 'error', 'abort'];
const BEGINS = ['playing', 'seeked', 'timeupdate'];
const UNTRACKED = 3; // s of film without a packet until it is said that there is no track
const NO_FORCE = Object.freeze({ x: 0, y: 0 });
const HIGHEST_ALPHA = 0.2; // s/px

const within = (value, low, high, otherwise) => Number.isFinite(value) ? Math.min(Math.max(value, low), high) : otherwise;

class Player {
  #video;
  #options;
  #track = new MotionTrack();
  #chain = new ForceChain();
  #rumble = new Rumble();
  #touch = null; // once a relief came
  #place = null;
  #pressed = false;
  #strength = 1;
  #clock;
  #ticks = false;
  #said = new Set();
  #ended = new AbortController();
  #release = () => {};

  constructor(video, options) {
    this.#video = video;
    this.#options = options;
    this.#clock = new FilmClock(video);
    this.strength = options.strength ?? 1;
    this.alpha = options.alpha ?? 0.01;
    const { signal } = this.#ended;
    const stop = () => this.#silence();
    for (const event of STOPS) video.addEventListener(event, stop, { signal });
    for (const event of ['pagehide', 'freeze']) window.addEventListener(event, stop, { signal });
    document.addEventListener('visibilitychange', () => document.hidden && stop(), { signal });
    window.addEventListener('gamepaddisconnected', stop, { signal });
    for (const event of ['seeking', 'seeked', 'emptied'])
      video.addEventListener(event, () => this.#clock.begin(), { signal });
    for (const event of BEGINS) video.addEventListener(event, () => this.#begin(), { signal });
    this.#followFrames();
    this.#begin();
  }

  async load(playlist) {
    const address = playlistAddress(playlist);
    this.#silence();
    this.#release();
    this.#release = () => {};
    this.#said.clear();
    const track = this.#track = new MotionTrack(); // no later film is felt by this one's packets
    this.#touch = null;
    const isWanted = () => this.#track === track && !this.#ended.signal.aborted;
    const release = await playFilm(this.#video, address, {
      onPacket: (bytes, time) => isWanted() && this.addPacket(bytes, time),
      onProblem: sentence => isWanted() && this.#say(sentence),
    });
    if (isWanted()) this.#release = release;
    else release();
  }

  addPacket(bytes, time) {
    if (this.#keep(this.#track, bytes, time)) this.#addReliefs(bytes.slice(), time);
  }

  get place() { return this.#place; }
  set place(place) {
    const valid = place && [place.x, place.y].every(Number.isFinite);
    this.#place = valid ? { x: within(place.x, 0, 1), y: within(place.y, 0, 1), z: within(place.z, -1, 1, 0) } : null;
  }
  get pressed() { return this.#pressed; }
  set pressed(pressed) { this.#pressed = Boolean(pressed); }
  get strength() { return this.#strength; }
  set strength(strength) { this.#strength = within(strength, 0, 1, this.#strength); }
  get alpha() { return this.#chain.alpha; }
  set alpha(alpha) { this.#chain.alpha = within(alpha, 0, HIGHEST_ALPHA, this.#chain.alpha); }
  get force() { return this.#chain.force; }
  get field() { return this.#track.fieldAt(this.#clock.at(performance.now())); }
  get relief() { return this.#touch?.track.shownAt(this.#clock.at(performance.now()))?.motion ?? null; }
  get contact() { return this.#touch?.contact ?? null; }
  get hasTrack() { return !this.#track.empty || this.#touch !== null; }
  get gamepads() { return rumblePads().map(pad => pad.id); }

  detach() {
    this.#silence();
    this.#ended.abort();
    this.#release();
  }

  #keep(track, bytes, time) {
    const hasReliefs = track.add(bytes, time);
    track.forgetBefore(forgottenBefore(this.#video.currentTime));
    if (track.damaged) this.#say('Some packets of the haptic track are damaged; they are not felt.');
    return hasReliefs;
  }

  // What reliefs need is loaded with the first one.
  async #addReliefs(bytes, time) {
    const track = this.#track;
    const module = await import('./touch.js').catch(() => this.#say('What can be touched cannot be loaded. Check the server.'));
    if (!module || track !== this.#track) return; // or of another film
    if (!this.#touch) {
      this.#touch = new module.Touch();
      this.#options.onRelief?.();
    }
    this.#keep(this.#touch.track, bytes, time);
  }

  // ---- what is felt now

  #followFrames() {
    const next = (_, { mediaTime, expectedDisplayTime }) => {
      if (this.#ended.signal.aborted) return;
      this.#clock.frame(mediaTime, expectedDisplayTime);
      this.#video.requestVideoFrameCallback(next);
    };
    this.#video.requestVideoFrameCallback?.(next);
  }

  get #plays() {
    const video = this.#video;
    return !this.#ended.signal.aborted && !document.hidden && !video.paused && !video.seeking && !video.ended &&
      video.readyState >= HTMLMediaElement.HAVE_FUTURE_DATA && video.playbackRate > 0 && video.playbackRate <= 2;
  }

  // While the film plays, each frame of the screen is a step; nothing runs while it rests.
  #begin() {
    if (this.#ticks || !this.#plays) return;
    this.#ticks = true;
    requestAnimationFrame(now => this.#tick(now));
  }

  #tick(now) {
    this.#ticks = false;
    if (!this.#plays) return this.#silence();
    this.#begin();
    const { currentTime, playbackRate, videoWidth } = this.#video;
    if (!videoWidth || !this.#video.requestVideoFrameCallback) this.#clock.look(now);
    if (currentTime > UNTRACKED && !this.hasTrack) this.#say('This film has no haptic track: nothing is felt.');
    if (this.#clock.stalls(now) || !this.#place) return this.#silence();
    const place = this.#place;
    this.#chain.advance(this.#clock.at(now), (time, since) => {
      const motion = this.#track.at(time, place, since);
      return this.#touch?.felt(motion, time, since, place, this.#pressed) ?? motion;
    }, playbackRate);
    this.#report(now);
  }

  #report(now) {
    const { force } = this.#chain;
    const newtons = Math.hypot(force.x, force.y);
    const wanted = magnitudes(newtons, this.#chain.maxForce, this.#strength);
    if (this.#options.rumble !== false) this.#rumble.play(wanted, now);
    this.#options.onForce?.({ ...force, newtons, ...wanted, time: this.#chain.time });
  }

  #silence() {
    this.#rumble.stop();
    this.#touch?.release();
    if (this.#chain.silent) return;
    this.#chain.silence();
    this.#options.onForce?.({ ...NO_FORCE, newtons: 0, ...magnitudes(0, 1, 1), time: this.#video.currentTime });
  }

  #say(sentence) {
    if (this.#said.has(sentence)) return;
    this.#said.add(sentence);
    this.#options.onProblem?.(sentence);
  }
}

/** See player.d.ts. */
export function attach(video, options = {}) {
  const player = new Player(video, options);
  if (options.playlist !== undefined)
    player.load(options.playlist).catch(error => options.onProblem?.(error.message));
  return player;
}
