// SPDX-License-Identifier: LGPL-2.1-or-later
// The force of the page against that of hapticsink, with the same track and the same hand:
//
//   force-test.mjs FELT-FORCES
import { spawnSync } from 'node:child_process';
import { ForceChain } from '../../pipelines/web/player/force-chain.js';
import { MotionTrack } from '../../pipelines/web/player/motion-track.js';
import { Hold } from '../../pipelines/web/player/hold.js';
import { promise } from './promise.mjs';

const { stdout: bytes, status } = spawnSync(process.argv[2], { maxBuffer: 2 ** 30 });
promise('hapticsink has computed its forces', status === 0 && bytes.length > 0);

let at = 0;
const number = () => bytes.readDoubleLE((at += 8) - 8);

function readTrack() {
  const track = new MotionTrack();
  for (let packets = number(); packets > 0; --packets) {
    const time = number(), size = number();
    track.add(bytes.subarray(at, at += size), time);
  }
  return track;
}

// A hand can tell forces apart that differ by 30 mN and 7 %.
const isFelt = (a, b) => Math.hypot(a.x - b.x, a.y - b.y) > Math.max(0.03, 0.07 * Math.hypot(b.x, b.y));

// The force at each frame of a screen whose times of the film go forth and back by 15 ms, and that on each millisecond.
function differsInJitter(track, place) {
  const jittering = new ForceChain(), ticking = new ForceChain();
  const at = (time, since) => track.at(time, place, since);
  const forces = Array.from({ length: 3000 }, (_, ms) => (ticking.tick(at(ms / 1000, (ms - 1) / 1000)), ticking.force));
  let largest = 0, furthest = 0;
  for (let ms = 0; ms < 2960; ms += 16) {
    const seen = ms + (ms % 3) * 15;
    furthest = Math.max(furthest, seen);
    jittering.advance(seen / 1000, at);
    const expected = forces[furthest];
    largest = Math.max(largest, Math.hypot(jittering.force.x - expected.x, jittering.force.y - expected.y));
  }
  return largest;
}

for (let seed = 1; at < bytes.length; ++seed) {
  const track = readTrack();
  const chain = new ForceChain();
  // As hapticsink presses: in the field from which the line begins.
  const player = new EventTarget();
  Object.defineProperty(player, 'field', { get: () => track.around(now, now)?.from.field });
  const hold = new Hold(player, new EventTarget());
  const states = new Set();
  let now = 0, wasPressed = false;
  let strongest = 0, largest = 0, felt = 0, strong = 0, worst = 0;
  const ticks = number();
  for (let tick = 0; tick < ticks; ++tick) {
    const place = { x: number(), y: number(), z: number() };
    const isPressed = number() > 0, force = { x: number(), y: number() };
    const time = now = tick / 1000;
    player.place = place;
    if (isPressed && !wasPressed) hold.press();
    if (!isPressed) hold.release();
    wasPressed = isPressed;
    states.add(hold.held?.state);
    chain.tick(track.at(time, place, time - 1e-3, hold.felt));
    const off = Math.hypot(chain.force.x - force.x, chain.force.y - force.y);
    if (off > largest) [largest, worst] = [off, time];
    strongest = Math.max(strongest, Math.hypot(force.x, force.y));
    strong += Math.hypot(force.x, force.y) > 0.1;
    felt += isFelt(chain.force, force);
  }
  console.log(`track ${seed}: ${ticks} ms, ${strong} above 0.1 N, up to ${strongest.toFixed(3)} N; `
    + `largest difference ${(1000 * largest).toFixed(3)} mN at ${worst} s`);
  promise('the hand moves over leaves that move', strong > ticks / 10);
  promise('no millisecond differs by what a hand can feel', felt === 0);
  if (states.size > 1) promise('a thing and a place are held, hidden and lost', states.size === 5);
  promise('times that jitter change nothing', differsInJitter(track, { x: 0.4, y: 0.4, z: 0 }) < 0.02);
  promise('nor by more than the slew limit allows in one', largest < 0.02);
}
