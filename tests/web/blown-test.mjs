// SPDX-License-Identifier: LGPL-2.1-or-later
// The hand that the page draws, in each browser that is there: it is where the pointer is, and blown from there by the
// force of the same frame of the screen or of the one before (docs/web.md, "Without a device").
//
//   blown-test.mjs WEB-FOLDER FILM-FOLDER     with cmaf.m3u8 of browser-test.sh
import { browsers, openBrowser, openPage } from './browser.mjs';
import { expectedForces, isFelt } from './expected-force.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films] = process.argv.slice(2);
const PLACE = [0.42, 0.42]; // where the film moves
const SENSITIVITY = 4, ALPHA = 0.01 * SENSITIVITY; // s/px
const FARTHEST = 0.08; // of the height of the picture, at 1 N
const FROM = 2, UNTIL = 8; // s of the film
const WITHIN = 1; // px
const BACK = 150; // ms
const GAP = 100; // ms without a frame of the film, which other work on the machine causes: it may end the force

// Runs in the page before its scripts: what force it computes, in each frame of the screen.
function keepForces() {
  window.computed = []; // {frame, now: ms, x, y: N}; after a stall Firefox may still tell the frame before it
  const dispatch = EventTarget.prototype.dispatchEvent;
  EventTarget.prototype.dispatchEvent = function (event) {
    if (event.type === 'force') {
      window.computed.push({ frame: document.timeline.currentTime, now: performance.now(), ...event.detail });
    }
    return dispatch.call(this, event);
  };
}

// Runs in the page: where the white ring of the hand is, in each frame of the screen, px from the pointer.
function keepHands(farthest, place) {
  const canvas = document.getElementById('drawing'), film = document.querySelector('video');
  const { clientWidth: width, clientHeight: height } = canvas; // of the picture, which fills it
  const [x, y] = [place.x * width, place.y * height];
  const reach = Math.ceil(farthest * height + Math.max(10, 0.03 * height)) + 4; // the ring and its line
  const [left, top] = [Math.round(x) - reach, Math.round(y) - reach];
  window.drawn = []; // {frame: ms, x, y: px}
  window.pictureHeight = height;
  // The circle through the white pixels, by least squares (Kåsa 1976): the arrow hides some of them.
  const middleOf = ({ data, width: columns }) => {
    let [n, sx, sy, sxx, syy, sxy, sxz, syz, sz] = Array(9).fill(0);
    for (let i = 0; i < data.length; i += 4) {
      if (Math.min(data[i], data[i + 1], data[i + 2]) < 200 || data[i + 3] < 200) continue;
      const [u, v] = [i / 4 % columns + 0.5, Math.floor(i / 4 / columns) + 0.5], z = u * u + v * v;
      [n, sx, sy, sz] = [n + 1, sx + u, sy + v, sz + z];
      [sxx, syy, sxy, sxz, syz] = [sxx + u * u, syy + v * v, sxy + u * v, sxz + u * z, syz + v * z];
    }
    if (n < 20) return null;
    const [a, b, d] = [sxx - sx * sx / n, sxy - sx * sy / n, syy - sy * sy / n];
    const [p, q] = [(sxz - sx * sz / n) / 2, (syz - sy * sz / n) / 2], det = a * d - b * b;
    return { x: (p * d - q * b) / det, y: (q * a - p * b) / det };
  };
  const look = frame => {
    requestAnimationFrame(look);
    const middle = middleOf(canvas.getContext('2d').getImageData(left, top, 2 * reach, 2 * reach));
    window.drawn.push({ frame, x: middle && middle.x + left - x, y: middle && middle.y + top - y });
  };
  look(document.timeline.currentTime);

  window.shown = []; // ms, of the frames of the film
  const show = now => {
    window.shown.push(now);
    film.requestVideoFrameCallback(show);
  };
  film.requestVideoFrameCallback(show);
}

const server = await serve([web, films]);
for (const name of browsers()) {
  const browser = await openBrowser(name);
  const page = await openPage(browser, server.origin, { width: 720, height: 700 });
  await page.evaluateOnNewDocument(keepForces);
  await page.goto(`${server.origin}/?playlist=cmaf.m3u8`);
  await page.waitForFunction(() => document.querySelector('video').readyState >= 3);
  await page.evaluate(sensitivity => {
    window.unplug();
    document.querySelector('video').muted = true;
    for (const [id, value] of [['blow', 100], ['sensitivity', sensitivity]]) {
      document.getElementById(id).value = value;
      document.getElementById(id).dispatchEvent(new Event('input'));
    }
  }, SENSITIVITY);
  await page.click('#play');
  const box = await (await page.$('#stage')).boundingBox();
  const [x, y] = [Math.round(box.x + PLACE[0] * box.width), Math.round(box.y + PLACE[1] * box.height)];
  await page.mouse.move(x, y);
  await page.waitForFunction(() => document.getElementById('stage').classList.contains('blown'));
  const timeIs = time => page.waitForFunction(time => document.querySelector('video').currentTime > time, {}, time);
  await timeIs(FROM);
  const place = { x: (x - box.x) / box.width, y: (y - box.y) / box.height };
  await page.evaluate(keepHands, FARTHEST, place);
  await timeIs(UNTIL);
  const { computed, drawn, shown, height } = await page.evaluate(() =>
    ({ computed: window.computed, drawn: window.drawn, shown: window.shown, height: window.pictureHeight }));

  // px between the drawn hand and the place to which the force of a frame blows it.
  const gap = (hand, force) => {
    const scale = FARTHEST * height / Math.max(Math.hypot(force.x, force.y), 1);
    return Math.hypot(hand.x - scale * force.x, hand.y + scale * force.y);
  };
  const forceAt = frame => computed.findLast(force => force.frame <= frame) ?? { x: 0, y: 0 };
  const seen = drawn.slice(3).map((hand, i) => {
    const [now, before, old] = [3, 2, 1].map(back => gap(hand, forceAt(drawn[i + back].frame)));
    return { hand, way: Math.hypot(hand.x, hand.y), now, late: Math.min(now, before), old };
  });
  const most = key => Math.max(...seen.map(hand => hand[key]));
  console.log(`${name}: ${seen.length} frames of a picture ${height} px high; the hand is blown up to `
    + `${most('way').toFixed(1)} px; off by ${most('now').toFixed(2)} px at most from the force of its frame, `
    + `${most('late').toFixed(2)} from that or the one before; two frames late `
    + `${seen.filter(hand => hand.old > WITHIN).length} would be wrong`);
  promise(`${name}: the hand is drawn in each frame, and blown`, drawn.every(hand => hand.x !== null)
    && seen.length > 60 && most('way') > 5);
  promise('within 1 px of the force, at most one frame late', most('late') <= WITHIN);
  promise('which two frames late it would not be', seen.some(hand => hand.old > WITHIN));
  const expected = expectedForces(`${films}/cmaf-film.m4s`, { place, alpha: ALPHA, until: UNTIL + 1 });
  const isHeldUp = now => shown.some((time, i) => now > time && now < (shown[i + 1] ?? Infinity) + GAP
    && (shown[i + 1] ?? now) - time > GAP);
  const forces = computed.filter(({ now, time }) => now > shown[0] + GAP && time < UNTIL && !isHeldUp(now));
  const drops = forces.filter(({ time, newtons }) => newtons === 0 && isFelt(expected, time));
  const errors = forces.map(({ time, newtons }) => Math.abs(newtons - expected[Math.round(60 * time)][1]))
    .sort((a, b) => a - b);
  const median = errors[errors.length >> 1];
  console.log(`${name}: ${drops.length} drops of ${forces.length} forces; `
    + `${(1000 * median).toFixed(1)} mN from the track at the pointer`);
  promise('the force of the page never drops while frames come', drops.length === 0);
  promise('and is that at the pointer', median < 0.003);

  // Without the time for which the machine drew nothing.
  const back = await page.evaluate(async (within, gap) => {
    const begin = performance.now(), film = document.querySelector('video');
    film.pause();
    while (performance.now() < begin + 400) await new Promise(requestAnimationFrame);
    const hands = window.drawn.filter(({ frame }) => frame > begin);
    return hands.slice(0, 1 + hands.findLastIndex(({ x, y }) => Math.hypot(x, y) > within))
      .map(({ frame }, i) => frame - (hands[i - 1]?.frame ?? begin)).filter(step => step < gap).reduce((sum, step) => sum + step, 0);
  }, WITHIN, GAP);
  console.log(`${name}: back ${back.toFixed(0)} ms after the film stopped`);
  promise('the hand is back within 150 ms of the end of the force', back <= BACK);
  await browser.close();
}
server.close();
