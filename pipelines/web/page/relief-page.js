// SPDX-License-Identifier: LGPL-2.1-or-later
// What the page shows of a film that can be touched: height as shading, and the touched place. It also reads what presses:
// the button of the mouse, a finger, a key, a button of a gamepad. The page loads this file with the first relief.
import { HALF } from '../player/contact.js';
import { clear, pictureIn } from '../player/drawing.js';
import { isButtonDown } from '../player/rumble.js';
import { addKey } from './hold-page.js';

const LIGHT = [-0.5, 0.5, Math.SQRT1_2]; // from the upper left; a unit vector, y up
const DARKEST = 0.65, BRIGHTEST = 0.45; // opacity of the shading
const KEYS = { P: 'press on the surface', H: 'height as shading' };
const HINT = 'This film can be touched: press the mouse button, a finger, P, or the first button of a gamepad.';
const COLOURS = { edge: '#000000', touched: '#009e73' }; // of Okabe and Ito, green: orange and blue are motion and force

// The heights, each the mean of the cell and those around it: the steps of the code are no slopes.
function smoothed({ columns, rows, z, validity }) {
  return z.map((_, i) => {
    const column = i % columns, row = Math.floor(i / columns);
    let sum = 0, count = 0;
    for (let y = Math.max(row - 1, 0); y <= Math.min(row + 1, rows - 1); ++y)
      for (let x = Math.max(column - 1, 0); x <= Math.min(column + 1, columns - 1); ++x)
        if (validity[y * columns + x] > 0) [sum, count] = [sum + z[y * columns + x], count + 1];
    return count ? sum / count : 0;
  });
}

/** Grey and opacity of each cell, as the pixels of a picture: lit slopes are white, the others black. */
export function shadingOf(relief) {
  const { columns, rows, validity } = relief, z = smoothed(relief);
  const pixels = new Uint8ClampedArray(4 * columns * rows);
  const width = 2 * HALF / columns, height = 2 * HALF / rows;
  // Rise over run between the neighbours that have a surface; `from` and `to` may be outside.
  const slope = (from, to, i, run) => {
    const isKnown = j => j !== null && validity[j] > 0;
    const cells = Number(isKnown(from)) + Number(isKnown(to));
    return cells ? (z[isKnown(to) ? to : i] - z[isKnown(from) ? from : i]) / (cells * run) : 0;
  };
  for (let i = 0; i < columns * rows; ++i) {
    if (!(validity[i] > 0)) continue;
    const column = i % columns, row = Math.floor(i / columns);
    const across = slope(column > 0 ? i - 1 : null, column + 1 < columns ? i + 1 : null, i, width);
    const up = slope(row + 1 < rows ? i + columns : null, row > 0 ? i - columns : null, i, height);
    const lit = (LIGHT[2] - LIGHT[0] * across - LIGHT[1] * up) / Math.hypot(across, up, 1) - LIGHT[2];
    pixels.fill(lit > 0 ? 255 : 0, 4 * i, 4 * i + 3);
    pixels[4 * i + 3] = 255 * (lit > 0 ? BRIGHTEST * lit / (1 - LIGHT[2]) : DARKEST * Math.min(-lit / LIGHT[2], 1));
  }
  return pixels;
}

// `cells`: a canvas with a pixel for each cell, and the relief that it shows.
function drawShading(context, picture, relief, cells) {
  if (cells.relief !== relief) {
    [cells.width, cells.height, cells.relief] = [relief.columns, relief.rows, relief];
    cells.getContext('2d').putImageData(new ImageData(shadingOf(relief), relief.columns, relief.rows), 0, 0);
  }
  context.imageSmoothingQuality = 'high';
  context.drawImage(cells, picture.x, picture.y, picture.width, picture.height);
}

// The touched place, larger the harder it is pressed, and the spring to the hand.
function drawContact(context, picture, { x, y, newtons }, place) {
  const at = { x: picture.x + x * picture.width, y: picture.y + y * picture.height };
  for (const [colour, more] of [[COLOURS.edge, 2], [COLOURS.touched, 0]]) {
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 3 + 2 * more;
    context.beginPath();
    context.moveTo(at.x, at.y);
    context.lineTo(picture.x + place.x * picture.width, picture.y + place.y * picture.height);
    context.stroke();
    context.beginPath();
    context.arc(at.x, at.y, 4 + 8 * Math.min(Math.max(newtons, 0), 1) + more, 0, 2 * Math.PI);
    context.fill();
  }
}

function draw(canvas, stage, film, player, isShaded, cells) {
  const context = clear(canvas, stage);
  const picture = pictureIn(stage, film);
  const relief = isShaded ? player.relief : null, { contact, place } = player;
  if (relief) drawShading(context, picture, relief, cells);
  if (contact && place) drawContact(context, picture, contact, place);
}

// Returns what sets player.pressed. The stage keeps a pointer that presses, wherever it goes.
function watchPressing(stage, player) {
  let isDown = false, isKeyDown = false;
  stage.addEventListener('pointerdown', event => {
    if (!event.isPrimary || event.button !== 0 || event.target.closest('button')) return;
    isDown = true;
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener('lostpointercapture', () => { isDown = false; });
  window.addEventListener('blur', () => { isKeyDown = false; });
  document.addEventListener('keyup', ({ key }) => { if (key.toLowerCase() === 'p') isKeyDown = false; });
  document.addEventListener('keydown', ({ key, ctrlKey, altKey, metaKey }) => {
    if (key.toLowerCase() === 'p' && !ctrlKey && !altKey && !metaKey) isKeyDown = true;
  });
  return () => {
    player.pressed = isDown || isKeyDown || isButtonDown();
  };
}

function addButton() {
  const button = document.getElementById('field').cloneNode(true);
  button.id = 'height';
  button.title = 'Height as shading (H)';
  button.setAttribute('aria-label', 'Show the height of the picture');
  button.setAttribute('aria-pressed', 'true');
  button.querySelector('path').setAttribute('d', 'M2 19 9 6l4 7 3-4 6 10z');
  button.addEventListener('click', () =>
    button.setAttribute('aria-pressed', String(button.getAttribute('aria-pressed') !== 'true')));
  document.addEventListener('keydown', ({ key, ctrlKey, altKey, metaKey }) => {
    if (key.toLowerCase() === 'h' && !ctrlKey && !altKey && !metaKey) button.click();
  });
  document.getElementById('field').after(button);
  return button;
}

function addWords() {
  document.getElementById('hold-key')?.remove(); // H is another key here
  for (const [key, what] of Object.entries(KEYS)) addKey(key, what);
  const hint = Object.assign(document.createElement('p'), { id: 'hint', textContent: HINT });
  Object.assign(hint.style, { margin: '.3rem 0 0', color: 'var(--quiet)' });
  document.getElementById('status').after(hint);
}

/** Shows the reliefs of the player's films over the stage, from now on. */
export function showReliefs(stage, film, player) {
  if (document.getElementById('relief')) return; // of the film before
  const canvas = Object.assign(document.createElement('canvas'), { id: 'relief' });
  canvas.setAttribute('aria-hidden', 'true');
  Object.assign(canvas.style, { position: 'absolute', inset: 0, width: '100%', height: '100%', pointerEvents: 'none' });
  document.getElementById('drawing').before(canvas);
  const button = addButton(), read = watchPressing(stage, player), cells = document.createElement('canvas');
  addWords();
  const frame = () => {
    requestAnimationFrame(frame);
    read();
    draw(canvas, stage, film, player, button.getAttribute('aria-pressed') === 'true', cells);
  };
  frame();
}
