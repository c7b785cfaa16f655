// SPDX-License-Identifier: LGPL-2.1-or-later
// What is held, in words, and its key in the list. The page loads this file when its film plays first.
import { Hold, watchHolding } from '../player/hold.js';

const WORDS = {
  held: 'You hold it: its motion is felt.',
  about: 'You hold this place: what moves about it is felt.',
  hidden: 'What you hold is hidden: nothing is felt until it comes back.',
  lost: 'What you held is lost: let go and press again.',
};
const PACE = 1000; // ms between two sentences, for screen readers

const make = (name, ...content) => {
  const element = document.createElement(name);
  element.append(...content);
  return element;
};

/** A further row in the list of keys. */
export function addKey(key, what) {
  const row = make('div', make('dt', make('kbd', key)), make('dd', what));
  document.querySelector('#keys dl').append(row);
  return row;
}

export function showHold(stage, film, player) {
  const hold = new Hold(player, film), poll = watchHolding(stage, hold, document);
  const words = Object.assign(make('p'), { id: 'held' });
  words.setAttribute('role', 'status');
  document.getElementById('status').after(words);
  setInterval(() => {
    const text = WORDS[hold.held?.state] ?? '';
    if (words.textContent !== text) words.textContent = text;
  }, PACE);
  if (!document.getElementById('relief')) // there H is another key
    addKey('H', 'hold what is under the hand; again: let go').id = 'hold-key';
  const frame = () => {
    requestAnimationFrame(frame);
    poll();
  };
  frame();
}
