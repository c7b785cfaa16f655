// SPDX-License-Identifier: LGPL-2.1-or-later
// Takes the pictures of the web page in Chromium; screenshots.sh calls it.
//
//   page-pictures.mjs CHROMIUM PACKAGES ORIGIN FOLDER
//     PACKAGES has node_modules/puppeteer-core; the page is at ORIGIN
import { createRequire } from 'node:module';

const [executablePath, packages, origin, folder] = process.argv.slice(2);
const LEAVES = [0.165, 0.565]; // of the frame
const delay = ms => new Promise(done => setTimeout(done, ms));
const browser = await createRequire(`${packages}/`)('puppeteer-core').launch({
  executablePath,
  args: ['--no-sandbox', '--autoplay-policy=no-user-gesture-required', '--mute-audio', '--hide-scrollbars',
    '--disable-dev-shm-usage'],
});

async function open(viewport) {
  const page = await browser.newPage();
  await page.setViewport(viewport);
  await page.goto(origin);
  await page.waitForFunction(() => document.querySelector('video').readyState >= 3);
  return page;
}
async function pointOf(page, [x, y]) {
  const box = await (await page.$('#stage')).boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}
async function playFrom(page, time) {
  await page.click('#begin');
  await page.evaluate(time => { document.querySelector('video').currentTime = time; }, time);
  await page.waitForFunction(time => document.querySelector('video').currentTime > time + 0.1, { polling: 20 }, time);
}
// The force of the page is read from its meter.
const isFelt = page => page.waitForFunction(least =>
  Number(document.getElementById('meter').getAttribute('aria-valuenow')) >= least, { polling: 'raf' }, 0.3);
const shoot = (page, name) => page.screenshot({ path: `${folder}/${name}.png` });

const desktop = { width: 960, height: 800 };
let page = await open(desktop);
await shoot(page, 'page');
await playFrom(page, 8);
await page.mouse.move(...await pointOf(page, LEAVES));
await isFelt(page);
await shoot(page, 'page-playing');
await page.close();

page = await open(desktop);
await playFrom(page, 8);
await page.mouse.move(...await pointOf(page, LEAVES));
await page.mouse.down();
await page.waitForFunction(() => /^You hold/.test(document.getElementById('held')?.textContent ?? ''));
await isFelt(page);
await shoot(page, 'page-hold');
await page.close();

page = await open({ width: 390, height: 700, hasTouch: true, isMobile: true });
await playFrom(page, 8);
const [x, y] = await pointOf(page, LEAVES);
await page.touchscreen.touchStart(x - 20, y); // a finger that moves holds nothing
await page.touchscreen.touchMove(x, y);
await isFelt(page);
await shoot(page, 'page-phone');
await browser.close();
