// SPDX-License-Identifier: LGPL-2.1-or-later
// A packaged film on its own server: two viewers at two places.
//
//   packaged-test.mjs ORIGIN FOLDER
import { openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';

const [origin, folder] = process.argv.slice(2);
const TREE = [0.42, 0.42], SKY = [0.8, 0.08];
const browser = await openBrowser();

async function strengthAt([x, y]) {
  const page = await openPage(browser, origin);
  await page.goto(`${origin}/${folder}/index.html`);
  await page.waitForFunction(() => document.querySelector('video').readyState >= 3);
  await page.click('#play');
  const box = await (await page.$('#stage')).boundingBox();
  await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
  await page.waitForFunction(() => document.querySelector('video').currentTime >= 9); // in the second segment
  const sum = await page.evaluate(() => window.motor.reduce((sum, effect) => sum + effect.weak, 0));
  const problems = await page.$eval('#problems', list => list.textContent.trim());
  console.log(problems, page.trouble);
  promise('no other host is asked and nothing is refused by the policy', page.trouble.length === 0);
  promise('and the page has no problem', problems === '');
  await page.close();
  return sum;
}
const [tree, sky] = [await strengthAt(TREE), await strengthAt(SKY)];
console.log(`sum of the magnitudes in 9 s: ${tree.toFixed(2)} on the tree, ${sky.toFixed(2)} on the sky`);
// The clouds drift, hardly faster than the deadband: their first key fields are coded above it, all others below.
promise('they feel different forces', tree > 2 && sky < 0.05 * tree);

// The times of all packets that the player gets of the first two segments. In this film, each frame has a field.
const page = await openPage(browser, origin);
await page.goto(`${origin}/${folder}/index.html`);
const times = await page.evaluate(async () => {
  const { playFilm } = await import('./player/film.js');
  const { default: hls } = await import('./player/hls.light.min.js');
  const times = new Set();
  await playFilm(document.createElement('video'), new URL('film.m3u8', location).href, {
    hls, signal: new AbortController().signal, onPacket: (_, time) => times.add(Math.round(time * 1000)), onProblem() {},
  });
  while (Math.max(...times) < 7000) await new Promise(done => setTimeout(done, 50));
  return [...times].sort((a, b) => a - b);
});
const gaps = times.slice(1).map((time, i) => time - times[i]);
promise('no field is lost, at the end of a segment neither', Math.max(...gaps) < 50);
await browser.close();
process.exit(0);
