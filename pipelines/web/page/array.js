// SPDX-License-Identifier: LGPL-2.1-or-later
// The actuators of an array over the film, as hapticarray map=field drives them (docs/arrays.md). The page loads this
// file only if its address asks for it: ?array=NAME shows NAME.ini, a layout in the folder of the page.
import { REFERENCE_WIDTH, arctanGain, confidenceGate, shareKept } from '../player/force-chain.js';
import { sampleField } from '../player/field-sampler.js';

const FEWEST = 2, MOST = 64; // actuators
const PANEL = 0.3; // of the shorter side of the film
const REST = 0.16; // of the largest dot, an actuator at rest
const WORDS = 2; // times a second, for screen readers

/** The places of the actuators in a layout, {x, y}, y up, in the order of the channels. */
export function readLayout(text) {
  const sections = new Map();
  let keys = {};
  for (const line of text.split('\n').map(line => line.trim())) {
    const [, section] = /^\[(.+)\]$/.exec(line) ?? [];
    const [, key, value] = /^([^#=]+?)\s*=\s*(.*)$/.exec(line) ?? [];
    if (section) sections.set(section, keys = {});
    else if (key) keys[key] = value;
  }
  const actuators = [];
  for (let actuator; (actuator = sections.get(`actuator-${actuators.length + 1}`));) {
    const place = { x: Number.parseFloat(actuator.x), y: Number.parseFloat(actuator.y) };
    if (!Number.isFinite(place.x + place.y)) throw new Error(`Actuator ${actuators.length + 1} of the array has no place.`);
    actuators.push(place);
  }
  if (actuators.length < FEWEST || actuators.length > MOST)
    throw new Error(`The array has ${actuators.length} actuators; it must have ${FEWEST} to ${MOST}.`);
  return actuators;
}

/** The same places in the frame, 0..1 from its top left corner: the box about all actuators is the frame. */
export function placesInFrame(actuators) {
  const axis = name => {
    const all = actuators.map(actuator => actuator[name]);
    const low = Math.min(...all), size = Math.max(...all) - low;
    return all.map(value => size > 0 ? (value - low) / size : 0.5);
  };
  const x = axis('x'), y = axis('y');
  return actuators.map((_, i) => ({ x: x[i], y: 1 - y[i] }));
}

/** The amplitude of each actuator, 0..1 of full scale. `field` may be null. */
export function levelsOf(field, places, alpha) {
  if (!field) return places.map(() => 0);
  const scale = REFERENCE_WIDTH / field.width;
  const aspect = (field.aspectD ?? 1) / (field.aspectN ?? 1);
  return places.map(place => {
    const { x, y, confidence } = sampleField(field, place);
    const speed = Math.hypot(scale * x, scale * aspect * y);
    const felt = shareKept(speed) * speed;
    return confidenceGate(confidence) * arctanGain(felt, alpha, 1) * felt;
  });
}

function drawPanel(canvas, stage, actuators, levels) {
  const dots = devicePixelRatio;
  const side = PANEL * Math.min(stage.clientWidth, stage.clientHeight);
  const low = { x: Math.min(...actuators.map(({ x }) => x)), y: Math.min(...actuators.map(({ y }) => y)) };
  const size = { x: Math.max(...actuators.map(({ x }) => x)) - low.x, y: Math.max(...actuators.map(({ y }) => y)) - low.y };
  const nearest = Math.min(...actuators.flatMap((a, i) => actuators.slice(i + 1).map(b => Math.hypot(a.x - b.x, a.y - b.y))));
  const scale = side / Math.max(size.x, size.y);
  const largest = Math.min(0.12 * side, 0.45 * scale * nearest), rim = 1.4 * largest;
  const width = scale * size.x + 2 * rim, height = scale * size.y + 2 * rim;
  [canvas.width, canvas.height] = [Math.round(dots * width), Math.round(dots * height)];
  Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
  const context = canvas.getContext('2d');
  context.scale(dots, dots);
  context.fillStyle = 'rgb(0 0 0 / 60%)';
  context.fillRect(0, 0, width, height);
  for (const [i, { x, y }] of actuators.entries()) {
    const circle = radius => {
      context.beginPath();
      context.arc(rim + scale * (x - low.x), height - rim - scale * (y - low.y), radius, 0, 2 * Math.PI);
    };
    context.strokeStyle = 'rgb(255 255 255 / 60%)';
    circle(largest);
    context.stroke();
    context.fillStyle = '#56b4e9'; // of Okabe and Ito, the blue of the force
    circle(largest * (REST + (1 - REST) * levels[i]));
    context.fill();
  }
}

/** Shows the array in the lower right corner of the stage. Fails with a sentence. */
export async function showArray(stage, film, player, name) {
  if (!/^[\w-]+$/.test(name)) throw new Error('An array is named by letters, digits, - and _ only.');
  const answer = await fetch(`${name}.ini`);
  if (!answer.ok) throw new Error(`There is no array “${name}” in the folder of this page.`);
  const actuators = readLayout(await answer.text());
  const places = placesInFrame(actuators);
  const canvas = document.createElement('canvas');
  canvas.id = 'array';
  canvas.setAttribute('role', 'img');
  Object.assign(canvas.style, { position: 'absolute', right: '3%', bottom: '3%', pointerEvents: 'none' });
  stage.append(canvas);
  let strongest = 0;
  const frame = () => {
    requestAnimationFrame(frame);
    const plays = !film.paused && !film.seeking && !film.ended;
    const levels = levelsOf(plays ? player.field : null, places, player.alpha);
    strongest = Math.max(...levels);
    drawPanel(canvas, stage, actuators, levels);
  };
  const describe = () => canvas.setAttribute('aria-label',
    `Array ${name}, ${actuators.length} actuators, the strongest at ${Math.round(100 * strongest)} %`);
  describe();
  setInterval(describe, 1000 / WORDS);
  frame();
}
