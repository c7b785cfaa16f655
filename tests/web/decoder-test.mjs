// SPDX-License-Identifier: LGPL-2.1-or-later
// The decoder of the page against the C++ one, bit for bit:
//
//   decoder-test.mjs DECODED-TRACKS GOLDEN.klv GOLDEN-RELIEF.klv COUNT
import { spawnSync } from 'node:child_process';
import { FieldDecoder } from '../../pipelines/web/player/field-codec.js';
import { readKlv } from '../../pipelines/web/player/klv.js';
import { RELIEF } from '../../pipelines/web/player/touch.js';
import { promise } from './promise.mjs';

const [program, ...given] = process.argv.slice(2);
const { stdout: records, status } = spawnSync(program, given, { maxBuffer: 2 ** 30 });
promise('the C++ readers have read', status === 0 && records.length > 0);

const RESULTS = ['field', 'missing', 'waiting', 'damaged'];
const KINDS = ['point', 'field', 'foreign', 'other version', 'other kind', 'damaged', 'relief'];

const word = new DataView(new ArrayBuffer(4));
const bits = number => (word.setFloat32(0, number), word.getUint32(0));

function hashOf(numbers, floats = []) {
  let hash = 2166136261;
  for (const number of numbers) hash = Math.imul(hash ^ number, 16777619);
  for (const number of floats) hash = Math.imul(hash ^ bits(number), 16777619);
  return hash >>> 0;
}

function hashOfField(field) {
  const cells = [];
  const values = field.z ? [field.z, field.stiffness, field.friction, field.validity] : [field.x, field.y, field.confidence];
  for (let i = 0; i < values[0].length; ++i) for (const numbers of values) cells.push(numbers[i]);
  return hashOf([field.interval % 2 ** 32 | 0, Math.floor(field.interval / 2 ** 32), field.flags, field.columns,
    field.rows, field.width, field.height, field.aspectN, field.aspectD], cells);
}

function decoded(decoder, bytes) {
  const result = decoder.push(bytes);
  const numbers = [RESULTS.indexOf(result), Number(decoder.lost)];
  if (result === 'field') {
    numbers.push(hashOfField(decoder.field));
    if (decoder.rest) numbers.push(hashOfField(decoder.rest));
  }
  return numbers;
}

const NOTHING_HELD = { state: 0, x: 0.5, y: 0.5, radius: 0 };

function hashOfPoint(p) {
  let hash = 2166136261;
  const held = p.held ?? NOTHING_HELD;
  for (const number of [p.x, p.y, p.spin, p.divergence, p.pointerX, p.pointerY, p.regionWidth, p.regionHeight,
    p.confidence, held.x, held.y, held.radius].map(bits)
    .concat([p.flags, p.width, p.height, p.aspectN, p.aspectD, p.points, p.model, held.state]))
    hash = Math.imul(hash ^ number, 16777619);
  return hash >>> 0;
}

function items(bytes) {
  const numbers = [];
  for (const item of readKlv(bytes)) {
    numbers.push(KINDS.indexOf(item.kind), item.offset);
    if (item.kind === 'point') numbers.push(hashOfPoint(item.point));
    numbers.push(hashOf([...item.code ?? [], ...item.things ?? []]));
  }
  return numbers;
}

const NEW_STREAM = 0, CODE = 1, NEW_RELIEFS = 3;
let decoder = null, isRelief = false;
const tally = {};
for (let at = 0; at < records.length;) {
  const type = records[at];
  const size = records.readUInt32LE(at + 1);
  const bytes = records.subarray(at + 5, at + 5 + size);
  at += 5 + size;
  const expected = Array.from({ length: records.readUInt32LE(at) }, (_, i) => records.readUInt32LE(at + 4 + 4 * i));
  at += 4 + 4 * expected.length;
  if (type === NEW_STREAM || type === NEW_RELIEFS) {
    isRelief = type === NEW_RELIEFS;
    decoder = isRelief ? new FieldDecoder(RELIEF) : new FieldDecoder();
    continue;
  }
  const found = type === CODE ? decoded(decoder, bytes) : items(bytes);
  if (String(found) !== String(expected))
    promise(`record type ${type}, ${bytes.toString('hex')}: C++ ${expected}, JavaScript ${found}`, false);
  const kind = type !== CODE ? `KLV ${KINDS[expected[0]] ?? 'nothing'}` : (isRelief ? 'relief ' : '') + RESULTS[expected[0]];
  tally[kind] = (tally[kind] ?? 0) + 1;
}
console.log(tally);
promise('both decoders read the same and refuse the same',
  [...RESULTS, ...RESULTS.map(result => `relief ${result}`), 'KLV point', 'KLV field', 'KLV relief', 'KLV damaged']
    .every(kind => tally[kind] > 0));
