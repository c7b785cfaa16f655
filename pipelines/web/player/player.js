// SPDX-License-Identifier: MIT
// The player without a page: attach() lets a hand feel the film in a video element (docs/web.md, "Embed it").
import { addressOf, forgottenBefore, loadTrack, playFilm } from './film.js';
import { ForceChain } from './force-chain.js';
import { MotionTrack } from './motion-track.js';
import { Problem, sentenceFor } from './problems.js';
import { Rumble, magnitudes, rumblePads } from './rumble.js';

export { Problem, Refusal } from './problems.js';

const STOPS = ['pause', 'seeking', 'ended', 'waiting', 'emptied', 'abort'];
const BEGINS = ['playing', 'seeked', 'timeupdate'];
const LONGEST_FRAME = 250; // ms, of the screen: no such frames come where nobody looks
const UNTRACKED = 3; // s of film without a packet until it is said that there is no track
const HIGHEST_ALPHA = 0.2; // s/px

const within = (value, low, high, otherwise) => Number.isFinite(value) ? Math.min(Math.max(value, low), high) : otherwise;

class Player extends EventTarget {
  hold = null; // of hold.js
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
  #loading = new AbortController(); // for the film that is played
  #goOn = null; // past damage of this film
  #awaitsTrack = false; // it is still asked for, or cannot be had
  #ticked = 0; // ms

  constructor(video, options) {
    super();
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
    video.addEventListener('error', () => this.#fail(video.error), { signal });
    if (video.error) this.#fail(video.error);
    this.#followFrames();
    this.#begin();
    const { playlist, track } = options;
    if (playlist !== undefined) this.load(playlist).catch(refusal => this.#say(refusal));
    else if (track !== undefined) this.loadTrack(track).catch(refusal => this.#say(refusal));
    options.signal?.addEventListener('abort', () => this.detach(), { signal });
    if (options.signal?.aborted) this.detach();
  }

  /** Plays a playlist with a track instead of the film before. */
  load(playlist) {
    return this.#load(playlist, (address, options) => playFilm(this.#video, address, options));
  }

  /** Feels the track in a file of KLV, which has the times of the film that the video plays by itself; null: none. */
  loadTrack(track) {
    return this.#load(track, async (address, { origins, signal }) => {
      if (!address) return;
      const bytes = await loadTrack(address, { origins, signal });
      if (!signal.aborted) this.addPacket(bytes);
    });
  }

  async #load(name, load) {
    const address = name === null ? null : addressOf(name, this.#options.allowedOrigins);
    this.#silence();
    this.hold?.release();
    this.#loading.abort();
    const { signal } = this.#loading = new AbortController();
    this.#said.clear();
    this.#track = new MotionTrack(); // no later film is felt by the packets of this one
    this.#touch = this.#goOn = null;
    this.#awaitsTrack = true;
    const { hls = standardHls, hlsConfig, allowedOrigins: origins = [] } = this.#options;
    const onProblem = problem => signal.aborted || this.#say(problem);
    const onPacket = (bytes, time) => signal.aborted || this.addPacket(bytes, time);
    const onDamage = goOn => { this.#goOn = goOn; };
    const isRead = load(address, { hls, hlsConfig, origins, signal, onProblem, onPacket, onDamage });
    await isRead.then(read => { if (!signal.aborted) this.#awaitsTrack = read === false; }, onProblem);
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
  get hasReliefs() { return this.#touch !== null; }
  get hasTrack() { return !this.#track.empty || this.hasReliefs; }
  get gamepads() { return rumblePads().map(pad => pad.id); }

  detach() {
    this.#silence();
    this.#ended.abort();
    this.#loading.abort();
  }

  #keep(track, bytes, time) {
    const hasReliefs = track.add(bytes, time), { buffered, currentTime } = this.#video;
    const kept = buffered?.length ? buffered.start(0) : Infinity; // no packet of it comes again
    if (time !== undefined) track.forgetBefore(Math.min(forgottenBefore(currentTime), kept));
    this.#tellDamage();
    return hasReliefs;
  }

  // Of a set as it comes, and of what is in it when it is decoded.
  #tellDamage() {
    if (this.#track.damaged || this.#touch?.track.damaged) this.#say(new Problem('track-damaged'));
  }

  // What reliefs need is loaded with the first one.
  async #addReliefs(bytes, time) {
    const track = this.#track;
    const module = await import('./touch.js').catch(() => this.#say(new Problem('touch-missing')));
    if (!module || track !== this.#track) return; // or of another film
    if (!this.#touch) {
      this.#touch = new module.Touch();
      this.#tell('relief');
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
    if (this.#ticks && performance.now() - this.#ticked > LONGEST_FRAME) this.#silence();
    if (this.#ticks || !this.#plays) return;
    this.#ticks = true;
    this.#ticked = performance.now();
    requestAnimationFrame(now => this.#tick(now));
  }

  #tick(now) {
    this.#ticks = false;
    if (!this.#plays) return this.#silence();
    this.#begin();
    const { currentTime, playbackRate, videoWidth } = this.#video;
    if (!videoWidth || !this.#video.requestVideoFrameCallback) this.#clock.look(now);
    if (currentTime > UNTRACKED && !this.hasTrack && !this.#awaitsTrack) this.#say(new Problem('no-track'));
    const place = this.#place ?? this.hold?.held;
    if (this.#clock.stalls(now) || !place) return this.#silence();
    this.#chain.advance(this.#clock.at(now), (time, since) => {
      const motion = this.#track.at(time, place, since, this.hold?.felt);
      return this.#touch?.felt(motion, time, since, place, this.#pressed) ?? motion;
    }, playbackRate);
    this.#tellDamage();
    this.#report(now);
  }

  #report(now) {
    const { force } = this.#chain;
    const newtons = Math.hypot(force.x, force.y);
    const wanted = magnitudes(newtons, this.#chain.maxForce, this.#strength);
    if (this.#options.rumble !== false) this.#rumble.play(wanted, now);
    this.#tell('force', { ...force, newtons, ...wanted, time: this.#chain.time });
  }

  #silence() {
    this.#rumble.stop();
    this.#touch?.release();
    if (this.#chain.silent) return;
    this.#chain.silence();
    this.#tell('force', { ...this.force, newtons: 0, ...magnitudes(0, 1, 1), time: this.#video.currentTime });
  }

  #say(problem) {
    if (!(problem instanceof Problem)) problem = new Problem('cannot-play', { details: problem.message });
    const sentence = sentenceFor(problem, this.#options.texts);
    if (this.#said.has(sentence)) return;
    this.#said.add(sentence);
    this.#tell('problem', sentence, problem.code);
  }

  // The video element gives up.
  #fail({ code, message: details }) {
    this.#silence();
    const goesOn = code === MediaError.MEDIA_ERR_DECODE && this.#goOn?.();
    this.#say(new Problem(goesOn ? 'part-damaged' : 'cannot-play', { details }));
  }

  // Calls the option onForce, onRelief or onProblem, and the listeners of the event.
  #tell(type, detail, code) {
    this.#options[`on${type[0].toUpperCase()}${type.slice(1)}`]?.(detail, code);
    this.dispatchEvent(Object.assign(new Event(type), { detail, code }));
  }
}

// ---- the time of the frame on the screen

// The element's currentTime is too coarse for it: in Firefox it moves in steps of 34 ms, of 83 ms at half the speed.
const SHORTEST_STALL = 120; // ms
const STALLED_FRAMES = 3; // intervals without a frame
const LONGEST_INTERVAL = 1; // s
const KEPT = 0.9; // of a long interval, each frame: a busy browser leaves out frames, now few and now many

class FilmClock {
  #video;
  #frame = null; // {time: s of the film, shown: ms} of the last frame
  #interval = 0; // s of the film, between the last frames

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
    if (interval > 0) this.#interval = Math.min(Math.max(interval, KEPT * this.#interval), LONGEST_INTERVAL);
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

// ---- the door

let standardHls;
/** From now on, players without the option `hls` take this class of hls.js. */
export function useHls(hls) { standardHls = hls; }

/** See player.d.ts. */
export function attach(video, options = {}) {
  return new Player(video, options);
}
