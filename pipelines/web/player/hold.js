// SPDX-License-Identifier: MIT
// Holds what is under the hand: which keys and buttons press, what is felt from then on, and the ring and the path that are
// drawn. A page loads this file once its film plays.
import { FieldHold } from './field-hold.js';
import { isButtonDown } from './rumble.js';

const LONG_PRESS = 400; // ms: a finger that only touches is the hand, a click stays a click
const FARTHEST = 10; // px of CSS that a finger may move in this time
const TRAIL = 1; // s
const KEPT = 2 * TRAIL; // s: what is known runs ahead of what is shown
const COLOURS = { edge: '#000000', held: '#009e73' }; // of Okabe and Ito

export class Hold {
  #player;
  #hold = new FieldHold();
  #ahead = null; // {field: the next one, z: of the hand, hold: after it}
  #samples = []; // {due: s, of the frame, x, y, confidence: what is felt, held}

  constructor(player, video, signal) {
    this.#player = player;
    player.hold = this;
    const release = () => this.release();
    for (const event of ['seeking', 'ended', 'emptied']) video.addEventListener(event, release, { signal });
    player.addEventListener('relief', release, { signal });
  }

  /** Takes what is under the hand; nothing in a film with a surface, which a press touches. */
  press() {
    const { place, field, hasReliefs } = this.#player, before = this.#hold.held;
    this.#clear();
    if (place && field && !hasReliefs) {
      this.#hold.press(place, field);
      this.#keep(field.due);
    }
    if (before || this.#hold.held) this.#tell();
  }

  release() {
    if (!this.#hold.held) return;
    this.#clear();
    this.#tell();
  }

  /** Whether a press touches a surface, and holds nothing. */
  get touches() { return this.#player.hasReliefs; }

  /** {state, x, y, radius, time} in the frame that is shown, or null */
  get held() { return this.#shown.at(-1)?.held ?? this.#hold.held; }

  /**
   * A knot of the track, as it is felt; `knots` leads to it. The one that is next comes without them, and is only looked
   * at: the hand may change until it is there.
   */
  felt = (knot, knots) => {
    if (!this.#hold.held || !knot.field || knot.due < this.#samples[0].due) return knot;
    if (knots && knot.due > this.#samples.at(-1).due) this.#follow(knots, knot.due);
    const { x, y, confidence } = knot.due > this.#samples.at(-1).due ? this.#after(knot)
      : this.#samples.findLast(({ due }) => due <= knot.due);
    return { ...knot, field: null, motion: { ...knot.motion, x, y, confidence }, measured: confidence > 0 };
  };

  // What is held once `field` came. It is asked for in each tick.
  #after({ field }) {
    const z = this.#player.place?.z;
    if (this.#ahead?.field !== field || this.#ahead.z !== z) {
      const hold = Object.assign(new FieldHold(), this.#hold);
      hold.step(field, z);
      this.#ahead = { field, z, hold };
    }
    return this.#ahead.hold;
  }

  // A page that was busy passes several knots at once. Where one may be missing, what is held is lost.
  #follow(knots, until) {
    const { state } = this.#hold.held, { due } = this.#samples.at(-1);
    if (knots[0].due > due) {
      this.#hold.lose();
      this.#ahead = null;
    }
    for (const knot of knots) {
      if (!knot.field || knot.due <= due || knot.due > until) continue;
      this.#hold = this.#after(knot);
      this.#keep(knot.due);
    }
    if (this.#hold.held.state !== state) this.#tell();
  }

  #keep(due) {
    const { x, y, confidence, held } = this.#hold;
    this.#samples.push({ due, x, y, confidence, held });
    if (this.#samples[0].due < due - KEPT) this.#samples.shift();
  }

  #clear() {
    this.#hold.release();
    this.#samples = [];
    this.#ahead = null;
  }

  #tell() {
    this.#player.dispatchEvent(Object.assign(new Event('hold'), { detail: this.#hold.held }));
  }

  get #shown() {
    const due = this.#player.field?.due ?? -Infinity;
    return this.#samples.filter(sample => sample.due <= due);
  }

  /** Draws the ring, its path and a word, as hapticoverlay does. @returns the place that the hand rides on, if it may */
  draw(context, picture) {
    const { held } = this;
    if (!held) return null;
    const isCalm = matchMedia('(prefers-reduced-motion: reduce)').matches;
    const line = Math.max(picture.height / 360, 1);
    const at = ({ x, y }) => [picture.x + x * picture.width, picture.y + y * picture.height];
    const isSeen = sample => /held|about/.test(sample?.held.state);
    context.beginPath();
    if (!isCalm)
      this.#shown.filter(({ held: { time } }) => time >= held.time - TRAIL).forEach((sample, i, samples) => {
        if (isSeen(sample)) context[isSeen(samples[i - 1]) ? 'lineTo' : 'moveTo'](...at(sample.held));
      });
    stroke(context, line, line);
    const radius = held.state === 'lost' ? 0 : Math.max(held.radius * picture.width, 4 * line);
    if (radius > 0) {
      context.setLineDash(held.state === 'held' ? [] : [3 * line, 8 * line]);
      context.beginPath();
      context.arc(...at(held), radius, 0, 2 * Math.PI);
      stroke(context, 2 * line, line);
      context.setLineDash([]);
    }
    if (held.state !== 'held') write(context, picture, held.state, at(held), Math.max(radius, 0.03 * picture.height) + 4 * line);
    return isCalm || radius === 0 ? null : held;
  }
}

function stroke(context, thickness, outline) {
  for (const [colour, more] of [[COLOURS.edge, 2 * outline], [COLOURS.held, 0]]) {
    context.strokeStyle = colour;
    context.lineWidth = thickness + more;
    context.stroke();
  }
}

// Above the place, or below it where there is no room.
function write(context, picture, word, [x, y], gap) {
  const size = Math.max(picture.height / 25, 14);
  context.font = `${size}px system-ui, sans-serif`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  const width = context.measureText(word).width + 0.6 * size, height = 1.6 * size;
  const middle = y - gap - height < picture.y ? y + gap + height / 2 : y - gap - height / 2;
  const centre = Math.min(Math.max(x, picture.x + width / 2), picture.x + picture.width - width / 2);
  context.fillStyle = '#000b';
  context.fillRect(centre - width / 2, middle - height / 2, width, height);
  context.fillStyle = '#fff';
  context.fillText(word, centre, middle);
}

/**
 * What a person does to hold: the button of a mouse, a finger that rests, the first button of a gamepad, and H, which holds
 * until it comes again. `keys` is where keys are listened for. @returns what is to be called with each frame
 */
export function watchHolding(stage, hold, keys, signal) {
  let by = null, timer = 0, down = null, isFinger = false, isLong = false, hadButton = false;
  const on = (target, events, listener, options) => {
    for (const event of events) target.addEventListener(event, listener, { signal, ...options });
  };
  const press = what => {
    hold.press();
    by = what;
  };
  const letGo = what => {
    if (by === what) hold.release();
  };
  const stopWaiting = () => clearTimeout(timer);
  on(stage, ['pointerdown'], event => {
    if (!event.isPrimary) return;
    isFinger = event.pointerType !== 'mouse';
    isLong = false;
    if (event.button !== 0 || event.target.closest?.('button')) return;
    down = event;
    if (isFinger) timer = setTimeout(() => press('pointer'), LONG_PRESS);
    else press('pointer');
  });
  on(stage, ['pointermove'], ({ isPrimary, clientX, clientY }) => {
    if (isPrimary && down && Math.hypot(clientX - down.clientX, clientY - down.clientY) > FARTHEST) stopWaiting();
  });
  on(window, ['pointerup', 'pointercancel'], ({ isPrimary, timeStamp }) => {
    if (!isPrimary || !down) return;
    isLong = by === 'pointer' && (hold.held !== null || hold.touches) && timeStamp - down.timeStamp >= LONG_PRESS;
    down = null;
    stopWaiting();
    letGo('pointer');
  });
  // The end of a hold or of a touch is no click, and a finger that holds asks for no menu.
  on(stage, ['click'], event => {
    if (isLong) [event.stopPropagation(), event.preventDefault()];
  }, { capture: true });
  on(stage, ['contextmenu'], event => {
    if (isFinger) event.preventDefault();
  });
  Object.assign(stage.style, { userSelect: 'none', webkitUserSelect: 'none', webkitTouchCallout: 'none' });
  const leave = () => {
    stopWaiting();
    hold.release();
  };
  on(window, ['blur', 'pagehide'], leave);
  on(document, ['visibilitychange'], leave);
  on(keys, ['keydown'], ({ key, repeat, ctrlKey, altKey, metaKey, target }) => {
    if (repeat || ctrlKey || altKey || metaKey || target.closest?.('dialog')) return;
    if (key === 'Escape') hold.release();
    if (key.toLowerCase() !== 'h') return;
    if (!hold.held) press('key');
    else if (by === 'key') hold.release();
    else by = 'key';
  });
  return () => {
    const hasButton = isButtonDown();
    if (hasButton !== hadButton) hasButton ? press('pad') : letGo('pad');
    hadButton = hasButton;
  };
}
