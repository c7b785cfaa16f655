// SPDX-License-Identifier: LGPL-2.1-or-later
// The time of the film, as browsers tell it: a force lasts as long as frames come, and no longer.
import { FakeVideo, beBusy, pass, waiting } from './fake-browser.mjs';
import { point } from './motion-sets.mjs';
import { promise } from './promise.mjs';
import { attach } from '../../pipelines/web/player/player.js';

const LENGTH = 60; // s, of the track

// A film that moves everywhere by `speedAt(time)` px/s, and its force at each frame of the screen.
function feel(video, speedAt = () => 100) {
  const forces = [];
  const player = attach(video, { onForce: force => forces.push(force) });
  for (let frame = 0; frame < 25 * LENGTH; ++frame) player.addPacket(point(speedAt(frame / 25)), frame / 25);
  player.place = { x: 0.5, y: 0.5 };
  return { player, forces };
}
const drops = forces => forces.filter(({ newtons }, i) => newtons === 0 && forces[i - 1]?.newtons > 0).length;
const mean = forces => forces.reduce((sum, { newtons }) => sum + newtons, 0) / forces.length;
// Slow enough that the force does not depend on the rate by more than the law's curve.
const expectedAt = rate => 2 / Math.PI * Math.atan(0.01 * 100 * rate);

// ms between two changes of currentTime: Chromium's is each frame of the screen; Firefox's grows as the rate falls.
for (const [browser, rate, step] of [['Chromium', 1, 16], ['Chromium', 0.5, 16], ['Firefox', 1, 34], ['Firefox', 0.75, 51],
  ['Firefox', 0.5, 83]]) {
  const video = new FakeVideo(step);
  video.playbackRate = rate;
  const { player, forces } = feel(video);
  video.play();
  pass(10, video);
  const felt = mean(forces.slice(30)), expected = expectedAt(rate);
  console.log(`${browser} at ${rate}: ${felt.toFixed(3)} N of ${expected.toFixed(3)}, ${drops(forces)} drops in 10 s`);
  promise(`the force does not drop in ${browser} at rate ${rate}`, drops(forces) === 0);
  promise('and is that of the law', Math.abs(felt / expected - 1) < 0.02);
  player.detach();
}

const stuck = new FakeVideo(34);
const { player: first, forces } = feel(stuck);
stuck.play();
pass(2, stuck);
stuck.stuck = true;
pass(0.08, stuck);
promise('a film that rests for 80 ms is still felt', first.force.x > 0);
pass(0.08, stuck); // 34 ms may lie before these, since the last frame
promise('after 160 ms it is a stall, and zero', first.force.x === 0 && forces.at(-1).newtons === 0);
stuck.stuck = false;
pass(0.5, stuck);
promise('it is felt again when frames come again', first.force.x > 0);

promise('while a film plays, frames of the screen are waited for', waiting() === 1);
stuck.pause();
pass(0.1, stuck);
promise('nothing is waited for while it is paused', waiting() === 0 && first.force.x === 0);
stuck.play();
pass(0.5, stuck);
promise('play is felt at once again', first.force.x > 0);
first.detach();
pass(0.1, stuck);
promise('nothing is waited for after detach()', waiting() === 0);

// A film that plays on in a frame of a page, scrolled out of view: browsers stop the frames of the screen there.
const unseen = new FakeVideo(16);
const { player: away } = feel(unseen);
unseen.play();
pass(2, unseen);
beBusy(0.3, unseen);
promise('the force stays until somebody notices', away.force.x > 0);
unseen.dispatchEvent(new Event('timeupdate'));
promise('and is zero where no frame of the screen came', away.force.x === 0);
pass(0.5, unseen);
promise('it is felt again in view', away.force.x > 0);
away.detach();

// A busy browser, which shows frames for 0.1 s and then none for 0.25 s, again and again.
const busy = new FakeVideo(16);
const { player: late, forces: slow } = feel(busy);
busy.play();
const hiccup = () => {
  pass(0.1, busy);
  busy.hides = true;
  pass(0.25, busy);
  busy.hides = false;
};
hiccup();
hiccup();
slow.length = 0;
for (let i = 0; i < 10; ++i) hiccup();
promise('a browser that leaves out frames does not drop the force', drops(slow) === 0 && mean(slow) > 0.45);
late.detach();

// A film that moves to the right, and from 20 s on to the left.
const sought = new FakeVideo(34);
const { player: elsewhere, forces: places } = feel(sought, time => time < 20 ? 100 : -100);
sought.play();
pass(2, sought);
sought.hides = true;
places.length = 0;
sought.seek(30);
pass(0.08, sought);
promise('after a seek nothing is felt until a frame of the new place is shown', places.length > 0
  && places.every(({ newtons }) => newtons === 0));
sought.hides = false;
pass(0.5, sought);
promise('and then the new place', elsewhere.force.x < -0.4 && places.at(-1).time > 30);
elsewhere.detach();

// A film of 3 s that moves to the right in its first half, and then to the left.
const loop = new FakeVideo(34);
loop.duration = 3;
const { player: again, forces: rounds } = feel(loop, time => time < 1.5 ? 100 : time < 3 ? -100 : 0);
loop.play();
for (const round of [1, 2, 3]) {
  rounds.length = 0;
  pass(1, loop);
  const right = rounds.at(-1).x;
  pass(1, loop);
  console.log(`round ${round}: ${right.toFixed(3)} N, then ${rounds.at(-1).x.toFixed(3)} N`);
  promise(`a film that begins again is felt in round ${round}`, right > 0.4 && rounds.at(-1).x < -0.4);
  promise('at its own time', rounds.at(-1).time < 3);
  pass(1, loop);
}
again.detach();
