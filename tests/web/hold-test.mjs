// SPDX-License-Identifier: LGPL-2.1-or-later
// A thing that is held (docs/web.md, "Hold"): where it is, what is felt of it, and when it is let go.
import { readFileSync } from 'node:fs';
import { FakeVideo, beBusy, pass } from './fake-browser.mjs';
import { emptyField, fieldWith, packedThings, set } from './motion-sets.mjs';
import { promise } from './promise.mjs';
import { FieldHold, readThings } from '../../pipelines/web/player/field-hold.js';
import { Hold } from '../../pipelines/web/player/hold.js';
import { readKlv } from '../../pipelines/web/player/klv.js';
import { attach } from '../../pipelines/web/player/player.js';

const isNear = (a, b, within = 1e-4) => Math.abs(a - b) <= within;
const isAt = (held, x, y, within) => isNear(held.x, x, within) && isNear(held.y, y, within);

// ---- the bytes

const read = bytes => [...readKlv(set([[1, [1]], [2, [1]], [32, emptyField()], [34, bytes]]))][0];
const two = [{ id: 0x0102, x: 0.25, y: 1, radius: 0.05 }, { id: 7, state: 'hidden', x: 0, y: 0.5, radius: 0 }];
const [first, second] = readThings(read(packedThings(two)).things);
promise('things of a field are read', first.id === 0x0102 && first.state === 'held' && isAt(first, 0.25, 1, 1e-5)
  && isNear(first.radius, 0.05, 1e-5) && second.id === 7 && second.state === 'hidden');
promise('a field may have none', readThings(undefined).length === 0 && read([]).kind === 'field');
const [relief] = readKlv(readFileSync(new URL('../data/golden-relief.klv', import.meta.url)));
promise('a relief has none', relief.kind === 'relief' && relief.things === undefined);
const whole = packedThings(two);
for (let size = 1; size < whole.length; ++size)
  if (read(whole.slice(0, size)).kind !== 'damaged') promise(`${size} bytes of two things are refused`, false);
promise('things that are cut off, too many or of another state are refused', [[33, 0, 0, 0],
  ...[0, 4, 5, 255].map(state => packedThings([{ id: 1, state, x: 0, y: 0 }]))].every(bytes => read(bytes).kind === 'damaged'));
const many = Array.from({ length: 32 }, (_, id) => ({ id, x: 0, y: 0 }));
promise('32 are not too many, and bytes of a later version may follow', readThings(read(packedThings(many)).things).length === 32
  && read([...whole, 1, 2, 3]).kind === 'field');

// ---- the arithmetic

// A field of 1920 x 1080 that moves everywhere by this many px/s.
const fieldOf = (things, [x, y] = [0, 0], more = {}) => ({
  columns: 2, rows: 2, width: 1920, height: 1080, flags: 0, interval: 40_000, things: Uint8Array.from(packedThings(things)),
  x: new Float32Array(4).fill(x), y: new Float32Array(4).fill(y), confidence: new Float32Array(4).fill(1), ...more,
});
const thing = (x, y, more) => [{ id: 3, x, y, radius: 0.02, ...more }];
const pressed = (x, y, field) => {
  const hold = new FieldHold();
  hold.press({ x, y }, field);
  return hold;
};

const swing = pressed(0.51, 0.5, fieldOf(thing(0.5, 0.5)));
promise('a thing is taken within its radius, and its place is its own', swing.held.state === 'held' && isAt(swing.held, 0.5, 0.5));
swing.step(fieldOf([{ id: 9, x: 0.51, y: 0.5 }, ...thing(0.51, 0.49)], [500, 0]));
promise('its velocity is the way it went, whatever the field says', isNear(swing.x, 0.01 * 1920 / 0.04, 1)
  && isNear(swing.y, -0.01 * 1080 / 0.04, 1) && swing.confidence === 1 && isNear(swing.held.time, 0.04));
swing.step(fieldOf(thing(0.52, 0.5, { state: 'hidden' })));
promise('while it is hidden nothing is felt', swing.held.state === 'hidden' && swing.confidence === 0 && swing.x === 0);
swing.step(fieldOf(thing(0.6, 0.5)));
promise('where it comes back is no motion', swing.held.state === 'held' && isAt(swing.held, 0.6, 0.5) && swing.confidence === 0);
swing.step(fieldOf(thing(0.61, 0.5)));
promise('its next motion is', swing.confidence === 1 && isNear(swing.x, 0.01 * 1920 / 0.04, 1));
swing.step(fieldOf(thing(0.6, 0.5, { state: 'about' }), [77, 5]));
promise('where it cannot be told, the field is felt at its place', swing.held.state === 'about' && swing.x === 77
  && isAt(swing.held, 0.6, 0.5));
swing.step(fieldOf([]));
swing.step(fieldOf(thing(0.6, 0.5)));
promise('lost is lost until the next press', swing.held.state === 'lost' && swing.confidence === 0 && isAt(swing.held, 0.6, 0.5));
promise('a small thing can be taken from 24 px away, and no farther',
  pressed(0.5 + 23 / 1920, 0.5, fieldOf(thing(0.5, 0.5, { radius: 0 }))).held.state === 'held'
  && pressed(0.5, 0.5 + 25 / 1080, fieldOf(thing(0.5, 0.5, { radius: 0 }))).held.state === 'about');
promise('of two the nearer one is taken, and none that is hidden', isAt(pressed(0.505, 0.5, fieldOf([
  ...thing(0.5, 0.5), { id: 4, x: 0.507, y: 0.5 }, { id: 5, state: 'hidden', x: 0.505, y: 0.5 }])).held, 0.507, 0.5));
for (const flags of [4, 8]) {
  const cut = pressed(0.5, 0.5, fieldOf(thing(0.5, 0.5)));
  cut.step(fieldOf(thing(0.5, 0.5), [0, 0], { flags }));
  promise('at a cut, and without a frame before, it is lost', cut.held.state === 'lost');
}

const drift = pressed(0.25, 0.75, fieldOf([]));
promise('without a thing the place is held', drift.held.state === 'about' && isAt(drift.held, 0.25, 0.75)
  && isNear(drift.held.radius, 82 / 1920, 1e-3));
for (let i = 0; i < 25; ++i) drift.step(fieldOf([], [192, -108]));
promise('it goes with the field', isAt(drift.held, 0.35, 0.65) && drift.x === 192 && drift.y === -108 && drift.confidence === 1);
for (let i = 0; i < 250; ++i) drift.step(fieldOf([], [960, -540]));
promise('to the border of the frame', isAt(drift.held, 1, 0) && drift.held.state === 'about');
drift.release();
drift.step(fieldOf([], [192, 0]));
promise('and nothing is left of it once it is let go', drift.held === null);

// ---- in a film

const SPEED = 240; // px/s of 1920 to the right: 44 px/s of the reference width
const placeAt = time => 0.2 + SPEED / 1920 * time;
// A film of a thing that moves on; `at(frame)` gives what else is true of it. Its hand is on the thing at 1 s.
function film(at = () => ({})) {
  const video = new FakeVideo(16), states = [];
  const player = attach(video);
  for (let frame = 0; frame < 250; ++frame) {
    const { flags, things = thing(placeAt(frame / 25), 0.5, at(frame)) } = at(frame);
    player.addPacket(fieldWith(things, flags), frame / 25);
  }
  player.addEventListener('hold', ({ detail }) => states.push(detail?.state ?? null));
  const hold = new Hold(player, video);
  player.place = { x: placeAt(1), y: 0.5 };
  video.play();
  pass(1, video);
  return { video, player, hold, states };
}

const plain = film();
promise('nothing is felt of a thing without a press', plain.player.force.x === 0 && plain.hold.held === null);
plain.hold.press();
pass(1, plain.video);
const expected = 2 / Math.PI * Math.atan(0.01 * SPEED * 352 / 1920);
console.log(`${plain.player.force.x.toFixed(3)} N of ${expected.toFixed(3)}, held at`, plain.hold.held);
promise('its motion is felt where it is, and not under the pointer', isNear(plain.player.force.x, expected, 0.01)
  && isNear(plain.hold.held.x, placeAt(2), 0.01) && plain.player.place.x === placeAt(1));
plain.player.place = null;
pass(0.5, plain.video);
promise('also when the pointer left the film', plain.player.force.x > 0 && plain.hold.held.state === 'held');
plain.video.pause();
pass(0.5, plain.video);
promise('a pause is no force, and keeps the thing', plain.player.force.x === 0 && plain.hold.held.state === 'held');
plain.video.play();
pass(0.5, plain.video);
promise('which is felt again when the film goes on', isNear(plain.player.force.x, expected, 0.01)
  && isNear(plain.hold.held.x, placeAt(3), 0.01));
plain.hold.release();
pass(0.2, plain.video);
promise('let go, it is gone', plain.player.force.x === 0 && plain.hold.held === null && String(plain.states) === 'held,');

// Of the tick, only the place is new.
const { step } = FieldHold.prototype;
let steps = 0;
FieldHold.prototype.step = function (...field) {
  ++steps;
  return step.apply(this, field);
};
const once = film();
once.hold.press();
pass(2, once.video);
console.log(`${steps} steps in 2 s`);
promise('a field is stepped through once, and not in each tick', steps > 48 && steps < 54);
FieldHold.prototype.step = step;
once.hold.press();
pass(0.5, once.video);
promise('what comes after the next press is that of what it took', String(once.states) === 'held,about'
  && once.hold.held.state === 'about');

const hidden = film(frame => frame >= 50 && frame < 75 ? { state: 'hidden' } : {});
hidden.hold.press();
pass(1.5, hidden.video);
promise('while it is hidden, nothing is felt', hidden.player.force.x === 0 && hidden.hold.held.state === 'hidden');
pass(1, hidden.video);
promise('and it is felt when it comes back', hidden.player.force.x > 0.9 * expected && String(hidden.states) === 'held,hidden,held');

for (const [what, change] of [['the film cuts', { flags: 4 }], ['it ends', { things: [] }]]) {
  const lost = film(frame => frame === 50 || (change.things && frame > 50) ? change : {});
  lost.hold.press();
  pass(2, lost.video);
  promise(`it is lost when ${what}, and nothing is felt until it is let go`, lost.player.force.x === 0
    && lost.hold.held.state === 'lost' && String(lost.states) === 'held,lost');
  lost.player.detach();
}

// As long as a page may be busy: the force begins anew, and what is held goes on.
const busy = film();
busy.hold.press();
pass(0.5, busy.video);
const { felt } = busy.hold;
let fastest = 0;
busy.hold.felt = (...knots) => {
  const knot = felt(...knots);
  fastest = Math.max(fastest, knot.motion.x);
  return knot;
};
beBusy(0.4, busy.video);
pass(0.3, busy.video);
console.log(`after a busy page at most ${fastest.toFixed(1)} px/s of ${SPEED}, held at`, busy.hold.held);
promise('no way of several frames is felt as that of one', isNear(fastest, SPEED, 1) && busy.player.force.x > 0.9 * expected);
promise('its time goes on as that of the film does', isNear(busy.hold.held.x, placeAt(1 + busy.hold.held.time), 0.006)
  && isNear(busy.hold.held.x, placeAt(busy.video.currentTime), 0.006));
for (const [what, seconds, cut] of [['in a cut that a busy page missed', 0.4, 45], ['of which more is missed than is kept', 3]]) {
  const missed = film(frame => frame === cut ? { flags: 4 } : {});
  missed.hold.press();
  pass(0.5, missed.video);
  beBusy(seconds, missed.video);
  pass(0.3, missed.video);
  promise(`it is lost ${what}`, missed.hold.held.state === 'lost' && missed.player.force.x === 0
    && String(missed.states) === 'held,lost');
}

for (const event of ['seeking', 'ended', 'emptied']) {
  const { video, player, hold } = film();
  hold.press();
  pass(0.5, video);
  video.dispatchEvent(new Event(event));
  promise(`it is let go at ${event}`, hold.held === null && hold.felt(1) === 1);
  player.detach();
}

// A surface is known some time before it begins.
const surface = film();
surface.hold.press();
const isKnown = new Promise(done => surface.player.addEventListener('relief', done));
promise('a film without a surface has no reliefs', !surface.player.hasReliefs);
surface.player.addPacket(set([[1, [1]], [2, [2]], [33, [...relief.code]]]), 5);
await isKnown;
promise('what is held is let go once the film has a surface', surface.hold.held === null && String(surface.states) === 'held,');
surface.hold.press();
promise('from then on a press holds nothing, also before the surface begins', surface.hold.held === null
  && surface.player.relief === null && surface.player.hasReliefs);

const other = film();
other.hold.press();
const gone = other.player.loadTrack('missing.klv');
promise('it is let go for another track', other.hold.held === null);
gone.catch(() => {});
const outside = film();
outside.player.place = null;
outside.hold.press();
promise('a press outside the film takes nothing', outside.hold.held === null);
outside.hold.press();
promise('of which nothing is told', outside.states.length === 0);
outside.player.place = { x: 0.9, y: 0.9 };
outside.hold.press();
outside.player.place = { x: 0.8, y: 0.9 };
outside.hold.press();
promise('a press that takes something else is told', String(outside.states) === 'about,about');
process.exit(0); // a track that is waited for
