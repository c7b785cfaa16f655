// SPDX-License-Identifier: LGPL-2.1-or-later
// Films that can be touched, in a real browser: shading, the touched place, and what is felt with the button of the mouse,
// a key and a finger.
//
//   relief-test.mjs WEB-FOLDER FILM-FOLDER WEB-FOLDER-WITHOUT-HLS [SCREENSHOTS]     with the films that browser-test.sh makes
import { join } from 'node:path';
import { openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films, poorWeb, shots] = process.argv.slice(2);
const browser = await openBrowser();
const server = await serve([web, films]), poor = await serve([poorWeb, films]);
const shoot = (page, name) => shots && page.screenshot({ path: join(shots, `${name}.png`) });

async function open(server, film, options) {
  const page = await openPage(browser, server.origin, options);
  page.asked = [];
  page.on('request', request => page.asked.push(new URL(request.url()).pathname));
  await page.goto(`${server.origin}/?playlist=${film}.m3u8`);
  await page.waitForFunction(() => document.querySelector('video').readyState >= 3);
  await page.click('#play');
  return page;
}
const timeIs = (page, time) => page.waitForFunction(time => document.querySelector('video').currentTime >= time, {}, time);
const felt = page => page.waitForFunction(() => window.motorAt(performance.now()) > 0, { polling: 10 });
const rests = page => page.waitForFunction(() => window.motorAt(performance.now()) === 0, { polling: 10 });
async function placeAt(page, x, y) {
  const box = await (await page.$('#stage')).boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}
// How many pixels of the canvas are shaded, and how many have the colour of the touched place.
const drawn = page => page.evaluate(() => {
  const canvas = document.getElementById('relief');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const count = { shaded: 0, touched: 0 };
  for (let i = 0; i < data.length; i += 4) {
    const isTouched = data[i] === 0 && data[i + 1] === 0x9E && data[i + 2] === 0x73 && data[i + 3] === 255;
    if (isTouched) ++count.touched;
    else if (data[i + 3] > 20) ++count.shaded;
  }
  return count;
});
// `drawnLike(page, condition)`: what is drawn once it is so, or what is drawn after 10 s.
async function drawnLike(page, condition) {
  const end = performance.now() + 10_000;
  for (;;) {
    const count = await drawn(page);
    if (condition(count) || performance.now() > end) return count;
    await new Promise(done => setTimeout(done, 20));
  }
}
const ON_BALL = [0.5, 0.36];

for (const [what, site] of [['with hls.js', server], ['without hls.js', poor]]) {
  const page = await open(site, 'ball');
  await page.mouse.move(...await placeAt(page, ...ON_BALL));
  await page.waitForSelector('#relief');
  await timeIs(page, 1);
  const hovering = await drawnLike(page, ({ shaded }) => shaded > 10_000);
  console.log(hovering);
  promise(`height is shading, ${what}`, hovering.shaded > 10_000 && hovering.touched === 0);
  promise('nothing is felt without pressing', await page.evaluate(() => !window.motor.some(({ weak }) => weak > 0)));
  await page.mouse.down();
  await felt(page);
  const pressed = await drawnLike(page, ({ touched }) => touched > 30);
  console.log(pressed);
  await shoot(page, `relief-${what.replaceAll(/\W/g, '-')}`);
  promise('with the button pressed the ball is felt, and the touched place is a dot', pressed.touched > 30);
  await page.mouse.up();
  await rests(page);
  promise('and no longer when it is let go', (await drawnLike(page, ({ touched }) => touched === 0)).touched === 0);
  await page.keyboard.down('p');
  await felt(page);
  await page.keyboard.up('p');
  await rests(page);
  promise('P presses', true);
  await page.keyboard.press('h');
  promise('H hides the shading', (await drawnLike(page, ({ shaded }) => shaded === 0)).shaded === 0);
  await page.keyboard.press('?');
  promise('the keys are in the list', /press on the surface/.test(await page.$eval('#keys', keys => keys.textContent)));
  await shoot(page, 'relief-keys');
  console.log(page.trouble, await page.$eval('#problems', list => list.textContent));
  promise('nothing is wrong', page.trouble.length === 0 && await page.$eval('#problems', list => list.textContent === ''));
  await page.close();
}

const packaged = await open(server, 'ball/film');
await packaged.waitForSelector('#relief');
await timeIs(packaged, 5); // the second segment
await packaged.mouse.move(...await placeAt(packaged, 0.32, 0.5)); // where the ball is
await packaged.mouse.down();
await felt(packaged);
promise('a packaged film is touched, in each segment', (await drawnLike(packaged, ({ touched }) => touched > 30)).touched > 30 && packaged.trouble.length === 0);
await packaged.close();

const both = await open(server, 'both');
await both.mouse.move(...await placeAt(both, 0.42, 0.42));
await felt(both);
promise('of a film with both the motion is felt without pressing', true);
await both.waitForSelector('#relief');
await timeIs(both, 2);
await both.mouse.down();
const together = await drawnLike(both, ({ touched }) => touched > 30);
await shoot(both, 'relief-both');
promise('and the surface with it', together.shaded > 10_000 && together.touched > 30 && both.trouble.length === 0);
await both.close();

const phone = await open(server, 'ball', { width: 390, height: 844, phone: true });
await timeIs(phone, 1);
await phone.touchscreen.touchStart(...await placeAt(phone, ...ON_BALL));
await felt(phone);
await shoot(phone, 'relief-phone');
await phone.touchscreen.touchEnd();
await rests(phone);
promise('a finger presses while it is there', true);
promise('nothing is wider than the phone', await phone.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
await phone.close();

const plain = await open(server, 'cmaf');
await timeIs(plain, 2);
promise('a film without reliefs loads nothing for them', !plain.asked.some(path => /touch|contact|relief/.test(path)));
await plain.close();

await browser.close();
for (const { close } of [server, poor]) close();
