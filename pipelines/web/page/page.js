// SPDX-License-Identifier: LGPL-2.1-or-later
// The page around the player: film, hand, controls and keys.
import { draw, pictureIn } from '../player/drawing.js';
import Hls from '../player/hls.light.min.js'; // null where the build has none
import { attach } from '../player/player.js';
import { blownBy, mayBeBlown } from './blown-hand.js';
import { StickHand } from './stick-hand.js';

const element = id => document.getElementById(id);
const [stage, film, canvas] = ['stage', 'film', 'drawing'].map(element);
const ALPHA = 0.01; // s/px, for each step of sensitivity
const SEEK = 5; // s
const STEP = 0.02; // of the picture, a key moves the hand
const WORDS = 2; // times a second, for screen readers

const asked = new URLSearchParams(location.search);
const player = attach(film, {
  playlist: asked.get('playlist') ?? 'film.m3u8',
  hls: Hls,
  hlsConfig: { workerPath: new URL('../player/hls.worker.js', import.meta.url).href },
  onProblem: addProblem,
  onRelief: () => load('./relief-page.js', 'showReliefs'),
});
const stick = new StickHand();
let touching = false;

function addProblem(sentence) {
  const item = document.createElement('li');
  item.textContent = sentence;
  element('problems').append(item);
}

// Loads what only some films or addresses need, and shows it.
async function load(file, show, ...options) {
  try {
    await (await import(file))[show](stage, film, player, ...options);
  } catch ({ message }) {
    addProblem(message);
  }
}

// ---- film

async function togglePlay() {
  if (!film.paused) return film.pause();
  try {
    await film.play();
    element('begin').hidden = true;
  } catch (error) {
    if (error.name === 'NotAllowedError') addProblem('The browser wants a click on Play first.');
  }
}

function seekBy(seconds) {
  if (Number.isFinite(film.duration)) film.currentTime = Math.min(Math.max(film.currentTime + seconds, 0), film.duration);
}

function clock(seconds) {
  const whole = Math.floor(Number.isFinite(seconds) ? seconds : 0);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, '0')}`;
}

function showTime() {
  const position = element('position');
  element('time').textContent = `${clock(film.currentTime)} / ${clock(film.duration)}`;
  if (Number.isFinite(film.duration)) position.max = film.duration;
  position.value = film.currentTime;
  position.setAttribute('aria-valuetext', `${clock(film.currentTime)} of ${clock(film.duration)}`);
}

function showPlaying() {
  const play = element('play');
  play.classList.toggle('playing', !film.paused);
  play.setAttribute('aria-label', film.paused ? 'Play' : 'Pause');
  if (!film.paused) element('begin').hidden = true;
}

film.addEventListener('play', () => load('./hold-page.js', 'showHold'), { once: true });
for (const event of ['play', 'pause', 'ended']) film.addEventListener(event, showPlaying);
for (const event of ['timeupdate', 'durationchange', 'seeked']) film.addEventListener(event, showTime);
film.addEventListener('loadedmetadata', () => {
  if (film.videoWidth > 0) element('player').style.setProperty('--ratio', film.videoWidth / film.videoHeight);
  else addProblem('There is sound only: this film has no picture.');
});
film.addEventListener('volumechange', () => element('sound').setAttribute('aria-pressed', String(!film.muted)));
element('position').addEventListener('input', event => { film.currentTime = Number(event.target.value); });
element('play').addEventListener('click', togglePlay);
element('begin').addEventListener('click', () => {
  togglePlay();
  stage.focus();
});

// ---- hand

function pointAt(event) {
  if (!event.isPrimary) return;
  const box = stage.getBoundingClientRect();
  const picture = pictureIn(stage, film);
  const x = (event.clientX - box.left - picture.x) / picture.width;
  const y = (event.clientY - box.top - picture.y) / picture.height;
  player.place = x >= 0 && x <= 1 && y >= 0 && y <= 1 ? { x, y } : null;
}

stage.addEventListener('pointerdown', event => {
  if (event.isPrimary) touching = event.pointerType !== 'mouse';
  pointAt(event);
});
stage.addEventListener('pointermove', pointAt);
stage.addEventListener('pointerleave', ({ isPrimary }) => { if (isPrimary) player.place = null; });
for (const event of ['pointerup', 'pointercancel'])
  stage.addEventListener(event, ({ isPrimary }) => { if (isPrimary && touching) player.place = null; });
stage.addEventListener('dblclick', toggleFull);

function moveHand(dx, dy) {
  const { x, y } = player.place ?? { x: 0.5, y: 0.5 };
  player.place = { x: x + dx, y: y + dy };
}

// ---- switches

function toggleFull() {
  if (document.fullscreenElement) document.exitFullscreen();
  else element('player').requestFullscreen?.();
}

function toggle(button) {
  const on = button.getAttribute('aria-pressed') !== 'true';
  button.setAttribute('aria-pressed', String(on));
}

function changeStrength(percent) {
  const strength = element('strength');
  strength.value = Number(strength.value) + percent;
  strength.dispatchEvent(new Event('input'));
}

function showSlider(slider, text) {
  slider.setAttribute('aria-valuetext', text);
  slider.title = text;
}

document.addEventListener('fullscreenchange', () =>
  element('full').setAttribute('aria-pressed', String(Boolean(document.fullscreenElement))));
element('full').addEventListener('click', toggleFull);
element('sound').addEventListener('click', () => { film.muted = !film.muted; });
element('field').addEventListener('click', event => toggle(event.currentTarget));
element('hear').addEventListener('click', ({ currentTarget: button }) => {
  toggle(button);
  load('./force-sound.js', 'hearForce', button.getAttribute('aria-pressed') === 'true');
});
element('help').addEventListener('click', () => element('keys').showModal());
element('strength').addEventListener('input', ({ target }) => {
  player.strength = Number(target.value) / 100;
  showSlider(target, `${target.value} %`);
});
element('blow').addEventListener('input', ({ target }) => {
  showSlider(target, `${target.value} %`);
  showBlown();
});
element('sensitivity').addEventListener('input', ({ target }) => {
  player.alpha = ALPHA * Number(target.value);
  showSlider(target, `${target.value} times`);
});

// ---- keys

// A browser may refuse a page its memory.
function remembered(name) {
  try {
    return localStorage.getItem(name);
  } catch {
    return null;
  }
}
function remember(name, value) {
  try {
    localStorage.setItem(name, value);
  } catch { /* then until the page is closed */ }
}

const KEYS = {
  ' ': togglePlay, k: togglePlay, j: () => seekBy(-SEEK), l: () => seekBy(SEEK), f: toggleFull,
  m: () => element('sound').click(), s: () => element('hear').click(),
  v: () => element('field').click(), '+': () => changeStrength(5),
  '-': () => changeStrength(-5), '?': () => element('help').click(), F1: () => element('help').click(),
  Escape: () => { player.place = null; },
};
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

// WCAG 2.1.4: who speaks to the browser, or whose hand trembles, can switch off keys that are one character.
const letters = element('letters');
letters.checked = remembered('letters') !== 'off';
letters.addEventListener('change', () => remember('letters', letters.checked ? 'on' : 'off'));

document.addEventListener('keydown', event => {
  const { target, key } = event;
  if (event.ctrlKey || event.altKey || event.metaKey || element('keys').open) return;
  if (key.length === 1 && key !== ' ' && !letters.checked) return event.stopImmediatePropagation();
  const isControl = target instanceof HTMLInputElement || (target instanceof HTMLButtonElement && key === ' ');
  const arrow = ARROWS[key];
  const action = KEYS[key.length === 1 ? key.toLowerCase() : key];
  if (arrow && target instanceof HTMLInputElement) return;
  if (arrow) moveHand(...arrow.map(step => step * STEP * (event.shiftKey ? 4 : 1)));
  else if (action && !(isControl && key === ' ')) action();
  else return;
  event.preventDefault();
});

// ---- what is seen

function showForce() {
  const newtons = Math.hypot(player.force.x, player.force.y);
  element('level').style.transform = `scaleX(${Math.min(newtons, 1)})`;
  element('newtons').textContent = `${newtons.toFixed(2)} N`;
}

let blow = 0; // 0..1, how far the drawn hand is blown

function showBlown() {
  const slider = element('blow');
  slider.disabled = !mayBeBlown(player);
  blow = slider.disabled ? 0 : Number(slider.value) / 100;
}

function direction({ x, y }) {
  const names = ['right', 'up and right', 'up', 'up and left', 'left', 'down and left', 'down', 'down and right'];
  return names[(Math.round(Math.atan2(y, x) / (Math.PI / 4)) + 8) % 8];
}

function describeForce() {
  const newtons = Math.hypot(player.force.x, player.force.y);
  const meter = element('meter');
  meter.setAttribute('aria-valuenow', Math.min(newtons, 1).toFixed(2));
  meter.setAttribute('aria-valuetext', newtons < 0.01 ? 'none' : `${newtons.toFixed(2)} newtons ${direction(player.force)}`);
}

function describeDevice() {
  const pads = player.gamepads;
  const phone = Boolean(navigator.vibrate) && matchMedia('(pointer: coarse)').matches;
  const text = pads.length ? `You feel it in your gamepad (${pads[0].replace(/ *\(.*/, '')}).`
    : phone ? 'Put a finger on the film: the phone vibrates as hard as the picture moves there.'
    : isSecureContext ? 'No gamepad: the arrow shows what you would feel. Connect one and press a button of it.'
    : 'The arrow shows what you would feel. Browsers give gamepads only to pages over https or from localhost.';
  const status = element('status');
  if (status.textContent !== text) status.textContent = text;
}

function frame(now) {
  requestAnimationFrame(frame);
  const step = stick.step(now);
  if (step) moveHand(step.x, step.y);
  showForce();
  const blown = blownBy(player.force, blow);
  stage.classList.toggle('blown', blow > 0 && player.place !== null); // the drawn hand in the place of the system's pointer
  draw(canvas, stage, film, {
    place: player.place, force: player.force, blown, hold: player.hold,
    field: element('field').getAttribute('aria-pressed') === 'true' ? player.field : null,
  });
}

if (asked.has('array')) load('./array.js', 'showArray', asked.get('array'));
for (const id of ['strength', 'sensitivity', 'blow']) element(id).dispatchEvent(new Event('input'));
setInterval(() => {
  describeForce();
  describeDevice();
  showBlown();
}, 1000 / WORDS);
describeDevice();
requestAnimationFrame(frame);
element('no-script').remove();
element('begin').hidden = false;
