// SPDX-License-Identifier: LGPL-2.1-or-later
// The surface of the page and the force on a finger against those of hapticsink, with the same reliefs; and what a
// finger feels of a film with motion and surface:
//
//   touch-test.mjs TOUCHED-SURFACES
import { spawnSync } from 'node:child_process';
import { Contact, DEPTH, Surface } from '../../pipelines/web/player/contact.js';
import { ForceChain } from '../../pipelines/web/player/force-chain.js';
import { shadingOf } from '../../pipelines/web/page/relief-page.js';
import { ReliefTrack, Touch } from '../../pipelines/web/player/touch.js';
import { promise } from './promise.mjs';

const { stdout: bytes, status } = spawnSync(process.argv[2], { maxBuffer: 2 ** 30 });
promise('hapticsink has read the reliefs', status === 0 && bytes.length > 0);
let at = 0;
const number = () => bytes.readDoubleLE((at += 8) - 8);
const numbers = count => Array.from({ length: count }, number);

// ---- the surface

const touch = new Touch();
const packets = Array.from({ length: number() }, () => {
  const time = number(), size = number();
  return { time, set: bytes.subarray(at, at += size) };
});
for (const { set, time } of packets) touch.track.add(set, time);
let touched = 0, holes = 0, furthest = 0, off = 0;
for (let probes = number(); probes > 0; --probes) {
  const [time, x, y, exists, ...expected] = numbers(7);
  const point = touch.track.at(time).surface.at(x, y);
  if (Boolean(point) !== Boolean(exists)) promise(`a surface at ${time} s, (${x}, ${y}): ${exists}`, false);
  if (!point) ++holes;
  if (!point) continue;
  ++touched;
  const difference = Math.max(...[point.z / 0.01, point.stiffness / 200, point.friction]
    .map((value, i) => Math.abs(value - expected[i] / [0.01, 200, 1][i])));
  furthest = Math.max(furthest, difference);
  off += difference > 1e-6;
}
console.log(`${touched} places with a surface, ${holes} without; largest difference ${furthest.toExponential(1)} of 10 mm, `
  + `200 N/m or 1; beyond a millionth at ${off}`);
// Behind a loss a line begins with a tick of hapticsink's, up to 1 ms later.
promise('the surface is that of hapticsink, also between reliefs and where some were lost', touched > 2000 && holes > 100
  && furthest < 5e-3 && off < 0.01 * touched);

// ---- the force on a finger

const isFelt = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) > Math.max(0.03, 0.07 * Math.hypot(...b));
const first = new ReliefTrack();
first.add(packets[0].set, 0);
const relief = first.shownAt(0).motion;
const surface = new Surface(relief, relief, 0);
const contact = new Contact();
const LIFTED = 300; // ms until hapticsink has lifted a hand that it finds beneath the surface
let felt = 0, largest = 0, strongest = 0, slid = 0;
const ticks = number();
for (let tick = 0; tick < ticks; ++tick) {
  const [x, y, proxyX, proxyY, ...force] = numbers(7);
  contact.step(surface, x, y);
  if (tick < LIFTED) continue;
  const found = [contact.force.x, contact.force.y, contact.force.z];
  felt += isFelt(found, force);
  largest = Math.max(largest, ...found.map((value, i) => Math.abs(value - force[i])));
  strongest = Math.max(strongest, Math.hypot(force[0], force[1]));
  slid = Math.max(slid, Math.hypot(contact.proxy.x - proxyX, contact.proxy.y - proxyY));
}
console.log(`${ticks} ms, along the picture up to ${strongest.toFixed(3)} N; largest difference `
  + `${(1000 * largest).toFixed(3)} mN, of the proxy ${(1e6 * slid).toFixed(1)} µm`);
promise('the finger meets slopes and friction', strongest > 0.2);
promise('no millisecond differs from hapticsink by what a hand can feel', felt === 0);

// ---- reliefs of known shape

const FRAME = { columns: 32, rows: 32, width: 320, height: 320, aspectN: 1, aspectD: 1, flags: 0, interval: 33_333 };
const reliefOf = (height, stiffness = 200, friction = 0) => {
  const cells = FRAME.columns * FRAME.rows, side = 0.05 / FRAME.columns;
  const of = value => Float32Array.from({ length: cells }, (_, i) => value((i % 32 - 15.5) * side, (15.5 - (i >> 5)) * side));
  return { ...FRAME, z: of(height), stiffness: of(() => stiffness), friction: of(() => friction), validity: of(() => 1) };
};
// The force after the finger was led along `path(tick)` for 500 ms.
function feel(relief, path) {
  const surface = new Surface(relief, relief, 0), contact = new Contact();
  for (let tick = 0; tick < 500; ++tick) contact.step(surface, ...path(tick));
  return contact.force;
}
const near = (value, wanted, within = 1e-3) => Math.abs(value - wanted) <= within;
const rests = () => [0, 0], moves = tick => [1e-5 * tick - 0.0025, 0];
const flat = feel(reliefOf(() => 0), moves);
promise('nothing is felt along a smooth level surface', near(flat.x, 0) && near(flat.z, 200 * DEPTH));
const slope = feel(reliefOf(x => x / 2), rests), steepness = Math.atan(0.5);
promise('a slope pushes down by the force times its sine', near(slope.x, -200 * DEPTH * Math.sin(steepness)) && near(slope.y, 0));
const wall = feel(reliefOf((x, y) => -3 * y), rests);
promise('nearly all of it where it is steep', near(wall.y, 200 * DEPTH * Math.sin(Math.atan(3)), 0.01) && near(wall.x, 0));
const rubbed = feel(reliefOf(() => 0, 100, 0.5), moves);
promise('friction holds back, µ of the push', near(rubbed.x, -0.5 * rubbed.z) && near(rubbed.z, 100 * DEPTH));
promise('a hole is not felt', feel({ ...reliefOf(x => x), validity: new Float32Array(1024) }, rests).z === 0);
const hardest = feel(reliefOf(() => 0, 1e5), rests);
promise('no surface is stiffer than 200 N/m', near(hardest.z, 200 * DEPTH));

const shading = shadingOf(reliefOf((x, y) => y < 0 ? x : 0));
const pixel = (column, row) => shading.slice(4 * (32 * row + column), 4 * (32 * row + column) + 4);
promise('a level place is not shaded', pixel(16, 4)[3] === 0);
promise('a slope towards the light is bright, one away from it dark', pixel(16, 28)[0] === 255
  && shadingOf(reliefOf(x => -x))[4 * 500] === 0 && shadingOf(reliefOf(x => -x))[4 * 500 + 3] > 50);

// ---- motion and surface

const HERE = { x: 0.5, y: 0.5, z: 0 };
const NOTHING = { x: 0, y: 0, confidence: 0, measured: false, cut: false, age: 0, interval: 0 };
const MOVES = { ...NOTHING, x: 50, confidence: 1, measured: true, interval: 0.04, width: 352, aspect: 1 };
function forceOn(motion, place, pressed) {
  const chain = new ForceChain();
  touch.release();
  chain.advance(0, () => motion);
  for (let ms = 10; ms <= 1000; ms += 10)
    chain.advance(ms / 1000, (time, since) => touch.felt(motion, time, since, place, pressed));
  return chain.force;
}
const steepest = { force: 0 };
for (let x = 0.25; x < 1; x += 0.05)
  for (let y = 0.05; y < 1; y += 0.05) {
    const { x: fx, y: fy } = forceOn(NOTHING, { x, y, z: 0 }, true);
    if (Math.hypot(fx, fy) > steepest.force) Object.assign(steepest, { force: Math.hypot(fx, fy), x, y, z: 0 });
  }
console.log(`felt most at (${steepest.x.toFixed(2)}, ${steepest.y.toFixed(2)}): ${steepest.force.toFixed(3)} N`);
promise('a surface alone is felt where it is pressed', steepest.force > 0.1);
const none = forceOn(NOTHING, steepest, false);
promise('and not without pressing', none.x === 0 && none.y === 0 && touch.contact === null);
const moved = forceOn(MOVES, steepest, false), both = forceOn(MOVES, steepest, true), pushed = forceOn(NOTHING, steepest, true);
promise('motion is felt without pressing, and both with it', moved.x > 0.2 && near(both.x, moved.x + pushed.x, 0.02) && near(both.y, moved.y + pushed.y, 0.02));
promise('the touched place is near the finger', (forceOn(NOTHING, steepest, true), touch.contact.newtons > 0.05)
  && Math.hypot(touch.contact.x - steepest.x, touch.contact.y - steepest.y) < 0.2);
const last = packets.at(-1).time;
const late = touch.felt(NOTHING, last + 0.5, last + 0.499, steepest, true);
promise('reliefs that end are felt no longer', late === NOTHING && touch.contact === null);
promise('a seek finds them again', touch.felt(NOTHING, 1, 0.999, steepest, true).push.z > 0);
promise('no place is no number', touch.felt(NOTHING, 1, 0.999, { x: NaN, y: 0.5 }, true).push.z === 0);

// Damaged packets, always the same ones.
let state = 1, most = 0;
const random = limit => (state = Math.imul(state, 1664525) + 1013904223 >>> 0) % limit;
for (let round = 0; round < 20; ++round) {
  const hostile = new Touch();
  for (const { set, time } of packets) {
    const damaged = Uint8Array.from(set);
    if (random(3) === 0) for (let times = random(3); times > 0; --times) damaged[random(damaged.length)] = random(256);
    hostile.track.add(damaged, time);
  }
  for (let time = 0; time < 4; time += 0.05) {
    const { push } = hostile.felt(NOTHING, time, time - 1e-3, { x: random(100) / 99, y: random(100) / 99 }, true);
    if (push) most = Math.max(most, Math.hypot(push.x, push.y, push.z));
  }
  if (round === 0) promise('damaged reliefs are counted', hostile.track.damaged > 0);
}
promise('and no force of a damaged track is above 1 N', most > 0 && most < 1 + 1e-9);
