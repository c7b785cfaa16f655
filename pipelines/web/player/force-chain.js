// SPDX-License-Identifier: MIT
// From a motion to the force of hapticsink with its defaults (force-law.cpp and motion-conditioning.cpp in
// gst-plugins/device, safety-chain.cpp in spidar): deadband, equation 5 of the paper, confidence, fades, slew limit,
// norm clamp.
// Without what needs a moving grip: damping, work and the brake of a turning grip.

export const REFERENCE_WIDTH = 352; // px
const STILL_SPEED = 3, MOVING_SPEED = 6; // px/s of the reference width
const RELEASE = 0.1; // s, of the deadband
const GATE_RELEASE = 0.1; // s
const GATE_NOTHING = 1e-3;
const SLEW_RATE = 20; // N/s
const TICK = 1e-3; // s
const LONGEST_FADE = 2; // s
const LONGEST_STEP = 0.25; // s
// s to zero, and s from zero to full after it.
const FADES = { gap: [0.1, 0.05], stale: [0.1, 0.05], cut: [0.05, 0.05] };

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
export const confidenceGate = confidence => clamp((confidence - 0.2) / 0.3, 0, 1);
export const staleAfter = interval => clamp(3 * interval, 0.1, 2);

export function shareKept(speed) {
  if (speed <= STILL_SPEED) return 0;
  if (speed >= MOVING_SPEED) return 1;
  return MOVING_SPEED / (MOVING_SPEED - STILL_SPEED) * (speed - STILL_SPEED) / speed;
}

// Equation 5 divided by the speed, finite at 0.
export function arctanGain(speed, alpha, most) {
  const t = alpha * speed;
  return 2 * most / Math.PI * (t < 1e-4 ? alpha * (1 - t * t / 3) : Math.atan(t) / speed);
}

function shorten(v, limit) {
  const norm = Math.hypot(v.x, v.y);
  return norm > limit ? { x: v.x * limit / norm, y: v.y * limit / norm } : v;
}

export class ForceChain {
  alpha = 0.01; // s/px
  maxForce = 1; // N
  /** N, x to the right, y up */
  force = { x: 0, y: 0 };

  #fastest = 0; // px/s, for the deadband
  #accepted = { x: 0, y: 0 }; // last wanted force worth trusting
  #holds = new Set(['gap']);
  #envelope = 0;
  #gate = 0;
  #fadeLeft = 0; // s until zero, while held
  #fadeIn = 0.05; // s
  #time = null; // s, of the last tick

  /** s of the film, that the force belongs to; null before the first tick. */
  get time() { return this.#time; }
  get silent() { return this.force.x === 0 && this.force.y === 0; }

  /** Zero at once; the force begins anew. */
  silence() {
    this.#envelope = this.#gate = this.#fastest = this.#fadeLeft = 0;
    this.#accepted = { x: 0, y: 0 };
    this.force = { x: 0, y: 0 };
    this.#holds = new Set(['gap']);
    this.#fadeIn = 0.05;
    this.#time = null;
  }

  /**
   * Moves on to `time` of the film (s) in ticks of 1 ms. `motionAt(time, since)` gives the motion under the hand;
   * `rate` is the speed of the film. A jump of more than a quarter of a second begins anew; the times of frames jitter,
   * so that a smaller step back is waited for.
   */
  advance(time, motionAt, rate = 1) {
    if (this.#time === null || Math.abs(time - this.#time) > LONGEST_STEP * Math.max(rate, 1)) {
      this.silence();
      this.#time = time - TICK * rate;
    }
    const step = TICK * rate;
    for (let now = this.#time + step; now <= time + 1e-9; now += step) {
      this.tick(motionAt(now, this.#time), rate);
      this.#time = now; // also after a tick that silenced
    }
    return this.force;
  }

  /** One tick with the motion of MotionTrack.at(), or of Touch.felt(): `share` of it is felt, and `push` (N) added. */
  tick(motion, rate = 1) {
    const holds = new Set();
    if (!motion.measured) holds.add('gap');
    else if (motion.age > staleAfter(motion.interval)) holds.add('stale');
    if (motion.cut || (this.#holds.has('cut') && !this.silent)) holds.add('cut');
    const wanted = this.#wanted(motion, rate);
    if (!Number.isFinite(wanted.x + wanted.y + motion.confidence)) return this.silence();
    const target = motion.measured ? confidenceGate(motion.confidence) : 0;
    this.#gate = target >= this.#gate ? target : target + (this.#gate - target) * Math.exp(-TICK / GATE_RELEASE);
    if (this.#gate < GATE_NOTHING) this.#gate = 0;
    if (holds.size) this.#fadeOut(holds);
    else this.#follow(wanted, motion);
  }

  // Equation 5 on the speed above the deadband, in px of the reference width; frame y is down, force y up.
  #wanted(motion, rate) {
    const scale = motion.width > 0 ? rate * REFERENCE_WIDTH / motion.width : rate;
    const x = scale * motion.x, y = scale * motion.y / (motion.aspect ?? 1);
    this.#fastest = Math.max(this.#fastest * Math.exp(-TICK / RELEASE), Math.hypot(x, y));
    const keep = shareKept(this.#fastest);
    const gain = keep * arctanGain(keep * Math.hypot(x, y), this.alpha, this.maxForce);
    const { share = 1, push } = motion;
    return { x: share * gain * x + (push?.x ?? 0), y: (push?.y ?? 0) - share * gain * y };
  }

  // F(t) = F(0) (1 - t / T), so that the force reaches zero after T.
  #fadeOut(holds) {
    if (!this.#holds.size) {
      this.#fadeLeft = LONGEST_FADE;
      if (this.#envelope >= 1) this.#fadeIn = 0; // else an interrupted fade-in keeps its slowness
    }
    for (const hold of holds) {
      if (!this.#holds.has(hold)) this.#fadeLeft = Math.min(this.#fadeLeft, FADES[hold][0]);
      this.#fadeIn = Math.max(this.#fadeIn, FADES[hold][1]);
    }
    this.#holds = holds;
    if (this.#fadeLeft <= TICK * (1 + 1e-6)) {
      this.#fadeLeft = this.#envelope = this.#gate = 0;
      this.#accepted = { x: 0, y: 0 };
      this.force = { x: 0, y: 0 };
      return;
    }
    const factor = (this.#fadeLeft - TICK) / this.#fadeLeft;
    this.#fadeLeft -= TICK;
    this.#envelope *= factor;
    this.force = { x: factor * this.force.x, y: factor * this.force.y };
  }

  #follow(wanted, motion) {
    this.#holds = new Set();
    this.#envelope = this.#fadeIn > 0 ? Math.min(this.#envelope + TICK / this.#fadeIn, 1) : 1;
    if (confidenceGate(motion.confidence) > 0) this.#accepted = wanted;
    const share = this.#gate * this.#envelope;
    const target = shorten(this.#accepted, this.maxForce);
    const change = shorten({ x: share * target.x - this.force.x, y: share * target.y - this.force.y }, SLEW_RATE * TICK);
    this.force = shorten({ x: this.force.x + change.x, y: this.force.y + change.y }, this.maxForce);
  }
}
