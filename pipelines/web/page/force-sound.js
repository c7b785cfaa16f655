// SPDX-License-Identifier: LGPL-2.1-or-later
// The force as a sound, for headphones (docs/web.md, "Without a device"). The page loads this file when it is asked to.

const LOUDEST = 0.1; // amplitude at 1 N: -20 dBFS
const MIDDLE = 330; // Hz, of a force to the side
const RAMP = 0.008; // s, without a click; shorter than the frames of a screen of 120 Hz

const clamp = value => Math.min(Math.max(value, -1), 1);

export class ForceSound {
  #context;
  #tone;
  #side;
  #level;
  #last = [MIDDLE, 0, 0];

  constructor(context) {
    this.#context = context;
    this.#tone = context.createOscillator();
    this.#level = new GainNode(context, { gain: 0 });
    this.#side = new StereoPannerNode(context);
    this.#tone.frequency.value = MIDDLE;
    this.#tone.connect(this.#level).connect(this.#side).connect(context.destination);
    this.#tone.start();
  }

  /** `force` in N, y up. Zero is digital silence once the ramp has ended. */
  hear({ x, y }, time = this.#context.currentTime) {
    const newtons = Math.min(Math.hypot(x, y), 1);
    const [tone, side] = newtons > 0 ? [MIDDLE * 2 ** clamp(y), clamp(x)] : this.#last; // a tone that ends stays there
    const next = [tone, side, LOUDEST * newtons];
    for (const [i, value] of [this.#tone.frequency, this.#side.pan, this.#level.gain].entries()) {
      value.setValueAtTime(this.#last[i], time);
      value.linearRampToValueAtTime(next[i], time + RAMP);
    }
    this.#last = next;
  }
}

let context = null, hear = null;

/** Turns the sound of the player's force on or off. */
export function hearForce(stage, film, player, on) {
  if (on && !context) {
    context = new AudioContext();
    const sound = new ForceSound(context);
    // In another state its time stands still, and nothing that is asked of it would ever be past.
    hear = force => { if (context.state === 'running') sound.hear(force); };
    player.addEventListener('force', ({ detail }) => hear(detail));
    context.addEventListener('statechange', () => hear(player.force)); // after a call, iOS goes on by itself
  }
  return on ? context.resume().then(() => hear(player.force)) : context?.suspend();
}
