// SPDX-License-Identifier: LGPL-2.1-or-later
// The force of the page in a browser against that of a running hapticsink, with the hand that its log has:
//
//   sink-test.mjs WEB-FOLDER FILM-FOLDER LOG.csv PAGE.csv
//
// LOG.csv is that of sink.ts with alpha=0.04; sink.m3u8 plays it. PAGE.csv gets the page's forces as such a log.
import { readFileSync, writeFileSync } from 'node:fs';
import { openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films, log, pageLog] = process.argv.slice(2);
const HALF = 0.025; // m, of the workspace of the simulated device
const SETTLED = 0.3; // s after a hold of the sink, or about a gap of the browser, which other work on the machine causes

const [head, ...lines] = readFileSync(log, 'utf8').trim().split('\n').map(line => line.split(','));
const column = name => head.indexOf(name);
const [TIME, X, Y, FX, FY, HOLD] = ['time', 'x', 'y', 'fx', 'fy', 'hold'].map(column);
let held = 0;
const rows = lines.map(line => {
  const row = line.map(Number);
  if (row[HOLD]) held = row[TIME];
  return {
    time: row[TIME], hand: { x: 0.5 + row[X] / (2 * HALF), y: 0.5 - row[Y] / (2 * HALF) }, x: row[FX], y: row[FY],
    free: row[TIME] - held > SETTLED,
  };
});
const rowAt = time => rows[Math.min(Math.max(Math.round((time - rows[0].time) * 1000), 0), rows.length - 1)];

// Without the begin and the end, where one may fade before the other.
const isCompared = ({ time }) => time > 0.5 && time < rows.at(-1).time - 0.5;

const server = await serve([web, films]);
const browser = await openBrowser();
const page = await openPage(browser, server.origin);
await page.goto(`${server.origin}/follow.html`);
await page.evaluate(hands => window.follow(hands), rows.filter((_, i) => i % 4 === 0).map(row => [row.time, row.hand]));
await page.waitForFunction(() => window.forces, { timeout: 60_000, polling: 200 });
const { forces, begin, gaps } = await page.evaluate(() => ({ forces: window.forces, begin: window.begin, gaps: window.gaps }));
const isSettled = time => gaps.every(gap => Math.abs(time - gap) > SETTLED);

// One row a millisecond, on straight lines between the frames of the screen; hapticsink's own where none is compared.
const written = rows.map(row => Array(head.length).fill(0).fill(row.time, TIME, TIME + 1));
let next = 0;
for (const [i, row] of written.entries()) {
  while (next + 1 < forces.length && forces[next + 1].time - begin <= row[TIME]) ++next;
  const from = forces[next], to = forces[next + 1] ?? from;
  const share = Math.min(Math.max((row[TIME] + begin - from.time) / (to.time - from.time || 1), 0), 1);
  const compared = rows[i].free && isSettled(rows[i].time + begin) && isCompared(rows[i]);
  row[FX] = compared ? from.x + (to.x - from.x) * share : rows[i].x;
  row[FY] = compared ? from.y + (to.y - from.y) * share : rows[i].y;
  row[column('confidence')] = 1;
}
writeFileSync(pageLog, [head, ...written].map(row => `${row.join(',')}\n`).join(''));

let felt = 0, squares = 0, count = 0, strong = 0;
for (const force of forces) {
  const row = rowAt(force.time - begin);
  if (!row.free || !isSettled(force.time) || !isCompared({ time: force.time - begin })) continue;
  const off = Math.hypot(force.x - row.x, force.y - row.y);
  squares += off * off;
  strong += Math.hypot(row.x, row.y) > 0.1;
  felt += off > Math.max(0.03, 0.07 * Math.hypot(row.x, row.y));
  ++count;
}
const share = felt / count;
console.log(`${count} forces, ${strong} above 0.1 N; a hand could tell ${(100 * share).toFixed(2)} %; `
  + `root mean square ${(1000 * Math.sqrt(squares / count)).toFixed(1)} mN; ${gaps.length} gaps`);
promise('forces are compared', count > 100 && strong > 20);
promise('the page feels as hapticsink does', share < 0.01);
await browser.close();
server.close();
