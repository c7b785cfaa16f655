// SPDX-License-Identifier: LGPL-2.1-or-later
// What is held in a browser against what hapticsink holds, of the same tracks and presses, bit for bit:
//
//   held-test.mjs HELD-FIELDS
import { spawnSync } from 'node:child_process';
import { FieldDecoder } from '../../pipelines/web/player/field-codec.js';
import { FieldHold } from '../../pipelines/web/player/field-hold.js';
import { readKlv } from '../../pipelines/web/player/klv.js';
import { promise } from './promise.mjs';

const STATES = ['none', 'held', 'about', 'hidden', 'lost'];
const { stdout: bytes, status } = spawnSync(process.argv[2], { maxBuffer: 2 ** 30 });
promise('FieldHold has held in C++', status === 0 && bytes.length > 0);

let at = 0;
const number = () => bytes.readDoubleLE((at += 8) - 8);

function readFields() {
  const decoder = new FieldDecoder();
  return Array.from({ length: number() }, () => {
    number(); // its time
    const size = number();
    const [{ code, things }] = readKlv(bytes.subarray(at, at += size));
    return decoder.push(code) === 'field' ? { ...decoder.field, things } : null;
  });
}

const tally = {};
let samples = 0;
while (at < bytes.length) {
  const fields = readFields();
  for (let presses = number(); presses > 0; --presses) {
    const first = number(), place = { x: number(), y: number(), z: number() }, count = number();
    const hold = new FieldHold();
    for (let i = 0; i < count; ++i, ++samples) {
      if (i === 0) hold.press(place, fields[first]);
      else hold.step(fields[first + i], place.z);
      const { state, x, y, radius, time } = hold.held;
      const found = [STATES.indexOf(state), x, y, radius, hold.x, hold.y, hold.confidence];
      const [stateOf, xOf, yOf, radiusOf, timeOf, ...motion] = Array.from({ length: 8 }, number);
      const expected = [stateOf, xOf, yOf, radiusOf, ...motion];
      // The code has intervals of whole µs, of which a sum is rounded.
      if (!found.every((value, j) => Object.is(value + 0, expected[j] + 0)) || Math.abs(time - timeOf) > 1e-9)
        promise(`field ${first} + ${i}: C++ ${expected}, ${timeOf}; JavaScript ${found}, ${time}`, false);
      tally[state] = (tally[state] ?? 0) + 1;
    }
  }
}
console.log(`${samples} samples`, tally);
promise('each sample is the same, bit for bit, in each state', STATES.slice(1).every(state => tally[state] > 100));
