// SPDX-License-Identifier: LGPL-2.1-or-later
// The array of the page: its layouts, and amplitudes as those of hapticarray map=field
// (tests/elements/hapticarray-test.cpp has the same field).
//
//   array-test.mjs WEB-FOLDER
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { levelsOf, placesInFrame, readLayout } from '../../pipelines/web/page/array.js';
import { promise } from './promise.mjs';

const layout = name => readLayout(readFileSync(join(process.argv[2], `${name}.ini`)).toString());
const COUNTS = { 'back-3x4': 12, 'ring-8': 8, 'shakers-2': 2, 'coils-2': 2 };
for (const [name, count] of Object.entries(COUNTS))
  promise(`${name} has ${count} actuators`, layout(name).length === count);
const back = placesInFrame(layout('back-3x4'));
promise('the first actuator of the back is top left, the last bottom right',
  back[0].x === 0 && back[0].y === 0 && back[11].x === 1 && back[11].y === 1);
promise('those of a line are in the middle of the frame', placesInFrame(layout('coils-2')).every(({ y }) => y === 0.5));

// The left half of the frame moves at 100 px/s.
const field = { columns: 32, rows: 24, width: 352, height: 288 };
const cells = Array.from({ length: 32 * 24 }, (_, cell) => cell % 32 < 16 ? 100 : 0);
Object.assign(field, { x: cells, y: cells.map(() => 0), confidence: cells.map(() => 1) });
const near = (a, b) => Math.abs(a - b) <= 0.01;
const full = 2 / Math.PI * Math.atan(0.01 * 100);
const [left, right] = levelsOf(field, placesInFrame(layout('shakers-2')), 0.01);
promise('an actuator vibrates as strong as the force would be', near(left, full));
promise('and rests where nothing moves', right === 0);
const doubt = { ...field, confidence: cells.map(() => 0.1) };
promise('nothing is felt of what is not sure', levelsOf(doubt, back, 0.01).every(level => level === 0));
promise('nor without a field', levelsOf(null, back, 0.01).every(level => level === 0));

const refusal = text => {
  try {
    return String(readLayout(text));
  } catch ({ message }) {
    return message;
  }
};
const actuators = count => Array.from({ length: count }, (_, i) => `[actuator-${i + 1}]\nx=${i}\ny=0\n`).join('');
promise('one actuator is refused', /has 1 actuators/.test(refusal(actuators(1))));
promise('and 65', /has 65 actuators/.test(refusal(actuators(65))));
promise('and one without a place', /Actuator 2 .* no place/.test(refusal(`${actuators(1)}[actuator-2]\nx=nowhere\ny=0\n`)));
promise('and what is no layout', /has 0 actuators/.test(refusal('<html>')));
