// SPDX-License-Identifier: MIT
// The reliefs of a film, and what a finger feels that presses on them. The player loads this file, and all for reliefs
// with it, with the first relief.
import { Contact, HALF, Surface } from './contact.js';
import { FieldDecoder } from './field-codec.js';
import { confidenceGate, staleAfter } from './force-chain.js';
import { PacketTrack } from './motion-track.js';
import { RELIEF } from './relief-codec.js';

const USUAL_INTERVAL = 1 / 30; // s, of a relief that has none

/** The surface at any time: straight lines between reliefs, as gst-plugins/device/touch/relief-timeline.cpp. */
export class ReliefTrack extends PacketTrack {
  constructor() { super(new FieldDecoder(RELIEF), ['relief']); }

  knotOf(relief, due, interval) { return { time: due, lasts: interval || USUAL_INTERVAL }; }

  /** {surface, cut: another scene began since `since`, age: s since the newest relief was due, interval: s}, or null */
  at(time, since = time) {
    const around = this.around(time, since);
    if (!around) return null;
    const { from, to, cut } = around;
    const begins = to && !to.cut ? Math.max(from.time, to.comes) : Infinity;
    const isLine = time >= begins;
    const weight = isLine ? (time - begins) / Math.max(to.time - begins, 1e-9) : 0;
    return {
      surface: new Surface(from.motion, isLine ? to.motion : from.motion, Math.min(weight, 1)), cut,
      age: isLine ? 0 : time - from.time, interval: (isLine ? to : from).lasts,
    };
  }
}

/** What is felt of reliefs beside the motion: hapticsink's touch=surface+motion. */
export class Touch {
  #contact = new Contact();
  track = new ReliefTrack();

  release() { this.#contact.release(); }

  /** Where the finger touches, 0..1 from the top left, and how deep the spring is pressed, N; or null. */
  get contact() {
    const { proxy, force } = this.#contact;
    return proxy && { x: 0.5 + proxy.x / (2 * HALF), y: 0.5 - proxy.y / (2 * HALF), newtons: force.z };
  }

  /** The motion of MotionTrack.at() and the contact of a finger at `place`, for ForceChain.tick(): one ms. */
  felt(motion, time, since, place, pressed) {
    const at = this.track.at(time, since);
    const isKnown = at && at.age <= staleAfter(at.interval);
    if (!isKnown || !pressed || at.cut) this.release();
    if (!isKnown) return motion;
    if (pressed) this.#contact.step(at.surface, (place.x - 0.5) * 2 * HALF, (0.5 - place.y) * 2 * HALF);
    const isFresh = motion.measured && motion.age <= staleAfter(motion.interval);
    return {
      ...motion, cut: motion.cut || at.cut, age: at.age, interval: at.interval, measured: true, confidence: 1,
      share: isFresh ? confidenceGate(motion.confidence) : 0, push: this.#contact.force,
    };
  }
}
