// SPDX-License-Identifier: LGPL-2.1-or-later
// Who holds a thing of a film, in each browser that is there: with the mouse, a finger, H and a gamepad, on the page and in
// the element.
//
//   pressing-test.mjs WEB-FOLDER FILM-FOLDER FOLDER-OF-ELEMENT [SCREENSHOTS]
//
// Each has the thing of add-things.mjs: the film held.m3u8 of the page, and the track film.klv of the element.
import { join } from 'node:path';
import { brokenRules, browsers, openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films, single, shots] = process.argv.slice(2);
const server = await serve([web, films]), embedding = single && await serve([single]);
const THING = [0.42, 0.42], NOTHING = [0.8, 0.08];
const delay = ms => new Promise(done => setTimeout(done, ms));
const shoot = (page, name) => shots && page.screenshot({ path: join(shots, `${name}.png`) });

// What is held is read from events, by the element's player or by the sentence of the page.
const wordsAre = (page, words) => page.waitForFunction(words =>
  new RegExp(words).test(document.getElementById('held')?.textContent ?? ''), { polling: 50 }, words);
const isQuiet = page => page.waitForFunction(() => document.getElementById('held')?.textContent === '', { polling: 50 });
const seek = (page, time) => page.evaluate(time => new Promise(done => {
  const film = document.querySelector('video');
  film.addEventListener('seeked', done, { once: true });
  film.currentTime = time;
}), time);
const timeIs = (page, time) => page.waitForFunction(time => document.querySelector('video').currentTime >= time, {}, time);

async function pointOf(page, [x, y], selector = '#stage') {
  const box = await (await page.$(selector)).boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

async function open(browser, options) {
  const page = await openPage(browser, server.origin, { width: 900, height: 760, ...options });
  await page.goto(`${server.origin}/?playlist=held.m3u8`);
  await page.waitForFunction(() => document.querySelector('video').readyState >= 3);
  await page.$eval('video', film => { film.loop = true; });
  await page.click('#play');
  await page.waitForSelector('#held');
  return page;
}
// The mouse is on the thing, and the film at a time; it takes a long way to its end, where it lets go.
async function begin(page, time = 1) {
  await seek(page, time);
  await timeIs(page, time + 0.1);
  await page.mouse.move(...await pointOf(page, NOTHING)); // to be another place
  await page.mouse.move(...await pointOf(page, THING));
}
// How many pixels of the page's drawing are green or white, and where their middle is, in parts of the width.
const drawn = (page, colour) => page.evaluate(colour => {
  const canvas = document.getElementById('drawing');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0, sum = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [red, green, blue, opacity] = data.subarray(i, i + 4);
    if (opacity > 250 && (colour === 'white' ? red > 250 && blue > 250 : red < 20 && green > 140 && blue > 100))
      [count, sum] = [count + 1, sum + i / 4 % canvas.width];
  }
  return { count, x: sum / count / canvas.width };
}, colour);
// How far what has this colour moves in a period of the thing.
async function wayOf(page, colour) {
  const middles = [];
  for (let i = 0; i < 12; ++i) {
    await delay(120);
    middles.push((await drawn(page, colour)).x);
  }
  console.log(`${colour}: ${middles.map(x => x.toFixed(3))}`);
  return Math.max(...middles) - Math.min(...middles);
}

async function withMouse(browser, name) {
  const page = await open(browser);
  await page.mouse.move(...await pointOf(page, NOTHING));
  await seek(page, 1.5);
  await page.mouse.down();
  await wordsAre(page, 'what moves about');
  promise(`${name}: a press where there is no thing holds the place`, true);
  await page.mouse.up();
  await isQuiet(page);
  await begin(page);
  await page.mouse.down();
  await wordsAre(page, '^You hold it');
  promise('the thing under the mouse is held while its button is down', true);
  promise('a green ring goes with it', await wayOf(page, 'green') > 0.03);
  await shoot(page, `${name}-held`);
  await page.mouse.move(...await pointOf(page, [0.9, 0.9]));
  await delay(1100);
  await wordsAre(page, '^You hold it');
  promise('also where the mouse is elsewhere, and the drawn hand rides on it', await wayOf(page, 'white') > 0.03);
  await page.mouse.up();
  await begin(page, 4.9);
  await page.mouse.down();
  await wordsAre(page, 'hidden');
  promise('the page says that it is hidden', true);
  await shoot(page, `${name}-hidden`);
  await wordsAre(page, '^You hold it');
  await page.mouse.up();
  await isQuiet(page);
  promise('let go, nothing is held or drawn', (await drawn(page, 'green')).count === 0);

  await begin(page);
  await page.keyboard.press('h');
  await wordsAre(page, '^You hold');
  await page.mouse.click(...await pointOf(page, THING));
  await isQuiet(page);
  promise('H holds without a button, until something else is pressed', true);
  await begin(page);
  await page.keyboard.press('h');
  await wordsAre(page, '^You hold');
  await page.keyboard.press('h');
  await isQuiet(page);
  promise('or H comes again', true);
  for (const [what, act] of [['Escape', () => page.keyboard.press('Escape')], ['a seek', () => seek(page, 2)],
    ['another window', () => page.evaluate(() => window.dispatchEvent(new Event('blur')))]]) {
    await begin(page);
    await page.keyboard.press('h');
    await wordsAre(page, '^You hold');
    await act();
    await isQuiet(page);
    promise(`${what} lets go`, true);
  }
  await page.click('#play');
  await page.mouse.move(...await pointOf(page, THING));
  await page.mouse.down();
  await page.mouse.up();
  promise('a click on the film does what it did: nothing', await page.$eval('video', film => film.paused));
  await page.click('#play');
  await begin(page);
  await page.evaluate(() => { navigator.getGamepads()[0].buttons = [{ pressed: true }]; });
  await wordsAre(page, '^You hold');
  await page.evaluate(() => { navigator.getGamepads()[0].buttons = [{ pressed: false }]; });
  await isQuiet(page);
  promise('the first button of a gamepad holds', true);
  await begin(page, 10.5);
  await page.mouse.down();
  await wordsAre(page, 'lost');
  await shoot(page, `${name}-lost`);
  await page.mouse.up();
  promise('what is gone is lost', true);
  console.log(page.trouble);
  promise('nothing is wrong', page.trouble.length === 0 && await page.$eval('#problems', list => list.textContent === ''));
  await page.close();
}

// What only Chromium can be told.
async function calmAndAccessible(browser) {
  const page = await open(browser);
  await page.emulateMediaFeatures([{ name: 'prefers-reduced-motion', value: 'reduce' }]);
  await begin(page);
  await page.keyboard.press('h');
  await wordsAre(page, '^You hold it');
  // The thing goes 0.08; the arrow hides a part of the hand, whose radius is 0.017, now on one side and now on the other.
  promise('for who wants less motion the hand stays at the pointer', await wayOf(page, 'white') < 0.017);
  await shoot(page, 'calm');
  await page.keyboard.press('h');
  await isQuiet(page);
  await page.$eval('#letters', letters => letters.click());
  await page.keyboard.press('h');
  await delay(1500);
  promise('H can be switched off with the other letters', await page.$eval('#held', words => words.textContent === ''));
  await page.$eval('#letters', letters => letters.click());
  await page.setBypassCSP(true);
  await page.reload();
  await page.click('#play');
  await page.waitForSelector('#held');
  await page.keyboard.press('?');
  promise('H is in the list of keys', /hold what is under/.test(await page.$eval('#keys', keys => keys.textContent)));
  const broken = await brokenRules(page);
  console.log(broken);
  promise('no rule of accessibility is broken', broken.length === 0);
  await page.close();
}

async function withFinger(browser) {
  const page = await open(browser, { width: 390, height: 844, phone: true });
  await page.evaluate(() => {
    window.menus = [];
    document.addEventListener('contextmenu', event => window.menus.push(event.defaultPrevented));
  });
  await seek(page, 1.8);
  const [x, y] = await pointOf(page, THING);
  await page.touchscreen.touchStart(x, y);
  await delay(200);
  await page.touchscreen.touchMove(x + 30, y);
  await delay(1400);
  promise('a finger that moves is the hand, and holds nothing', await page.$eval('#held', words => words.textContent === ''));
  await page.touchscreen.touchEnd();
  await seek(page, 1.8);
  await page.touchscreen.touchStart(x, y);
  await wordsAre(page, '^You hold');
  await page.touchscreen.touchMove(x + 30, y);
  await delay(1200);
  await shoot(page, 'phone-held');
  await wordsAre(page, '^You hold');
  promise('a finger that rests for 400 ms holds, also when it moves then', true);
  await page.$eval('#stage', stage => stage.dispatchEvent(new PointerEvent('contextmenu', { bubbles: true, cancelable: true })));
  promise('it opens no menu and selects no text', await page.evaluate(() => window.menus.length > 0 && window.menus.every(Boolean)
    && getComputedStyle(document.getElementById('stage')).userSelect === 'none'));
  await page.touchscreen.touchEnd();
  await isQuiet(page);
  promise('and lets go when it is lifted', true);
  await page.touchscreen.touchStart(x, y);
  await wordsAre(page, '^You hold');
  await page.$eval('#stage', stage => stage.dispatchEvent(new PointerEvent('pointercancel', { bubbles: true, isPrimary: true })));
  await isQuiet(page);
  promise('or taken away by the system', page.trouble.length === 0);
  await page.close();
}

async function inElement(browser, name) {
  const page = await openPage(browser, embedding.origin, { width: 700, height: 560 });
  await page.goto(`${embedding.origin}/`);
  await page.waitForFunction(() => document.querySelector('feeling-wind')?.video?.readyState >= 3);
  await page.evaluate(() => {
    const { video } = document.querySelector('feeling-wind');
    Object.assign(video, { muted: true, loop: true });
    window.states = [];
    document.querySelector('feeling-wind').addEventListener('hold', ({ detail }) => window.states.push(detail?.state ?? null));
    return video.play();
  });
  const isHeld = held => page.waitForFunction(held =>
    Boolean(document.querySelector('feeling-wind').player.hold.held) === held, { polling: 20 }, held);
  await page.waitForFunction(() => document.querySelector('feeling-wind').player.field);
  await page.mouse.move(...await pointOf(page, [0.42, 0.3], 'feeling-wind'));
  // Firefox keeps what is pressed on its own controls to itself.
  await page.evaluate(controls => { document.querySelector('feeling-wind').video.controls = controls; }, name === 'chromium');
  const plays = () => page.evaluate(() => !document.querySelector('feeling-wind').video.paused);
  await page.mouse.down();
  await isHeld(true);
  await delay(800);
  await shoot(page, `${name}-element`);
  await page.mouse.up();
  await isHeld(false);
  await delay(200);
  promise(`${name}: the mouse holds in the element, and the film plays on`, await plays());
  await page.mouse.down();
  await page.mouse.up();
  await delay(200);
  promise('a click there does what it did', await plays() === (name !== 'chromium'));
  await page.evaluate(() => {
    const { player, video } = document.querySelector('feeling-wind');
    Object.defineProperty(player, 'hasReliefs', { value: true, configurable: true });
    return video.play();
  });
  await page.mouse.down();
  await delay(800);
  await page.mouse.up();
  await delay(200);
  promise('nor does the end of a touch stop it, which holds nothing', await plays());
  await page.evaluate(() => { delete document.querySelector('feeling-wind').player.hasReliefs; });
  await page.evaluate(() => {
    const { video } = document.querySelector('feeling-wind');
    video.controls = true;
    return video.play();
  });
  await page.focus('feeling-wind');
  await page.keyboard.press('h');
  await isHeld(true);
  await page.keyboard.press('h');
  await isHeld(false);
  promise('H holds there, too', page.trouble.length === 0);
  console.log(await page.evaluate(() => String(window.states)));
  await page.close();
}

for (const name of browsers()) {
  const browser = await openBrowser(name);
  await withMouse(browser, name);
  if (name === 'chromium') {
    await calmAndAccessible(browser);
    await withFinger(browser);
  }
  if (embedding) await inElement(browser, name);
  await browser.close();
}
server.close();
embedding?.close();
