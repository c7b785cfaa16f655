// SPDX-License-Identifier: LGPL-2.1-or-later
// The page as people use it: keys, touch, stick, screen reader, phone and desktop, light and dark.
//
//   page-test.mjs WEB-FOLDER FILM-FOLDER [SCREENSHOTS]
import { join } from 'node:path';
import { brokenRules, openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films, shots] = process.argv.slice(2);
const server = await serve([web, films]);
const browser = await openBrowser();

async function open(options, query = '') {
  const page = await openPage(browser, server.origin, options);
  await page.goto(`${server.origin}/${query}`);
  await page.waitForFunction(() => document.querySelector('video').readyState >= 3);
  await page.$eval('video', film => { film.loop = true; }); // however slow the browser is
  return page;
}
const shoot = (page, name) => shots && page.screenshot({ path: join(shots, `${name}.png`) });
const felt = page => page.waitForFunction(() => window.motorAt(performance.now()) > 0, { polling: 10 });

const keys = await open();
await shoot(keys, 'desktop-begin');
await keys.keyboard.press('k');
await keys.waitForFunction(() => document.querySelector('video').currentTime > 2);
await keys.focus('#stage');
await keys.keyboard.press('ArrowLeft');
await felt(keys);
promise('the film is played and felt by keys alone', true);
await keys.waitForFunction(() => /newtons/.test(document.getElementById('meter').getAttribute('aria-valuetext')));
promise('a screen reader finds the force in words', true);
await keys.keyboard.press('v');
await keys.waitForFunction(() => document.getElementById('field').getAttribute('aria-pressed') === 'true');
await new Promise(done => setTimeout(done, 300));
await shoot(keys, 'desktop-light');
await keys.keyboard.press('Escape');
await keys.waitForFunction(() => window.motorAt(performance.now()) === 0, { polling: 10 });
promise('Escape takes the hand away', true);
await keys.keyboard.press('?');
promise('? shows the keys', await keys.$eval('#keys', dialog => dialog.open));
await shoot(keys, 'desktop-keys');
await keys.keyboard.press('Escape');
await keys.keyboard.press('F1');
promise('and so does F1', await keys.$eval('#keys', dialog => dialog.open));
await keys.keyboard.press('Escape');
await keys.keyboard.press('m');
promise('M turns the sound off', await keys.$eval('video', film => film.muted));
await keys.evaluate(() => { window.stick[0] = -0.2; }); // slowly: the tree is near
await felt(keys);
promise('the stick moves the hand', true);
await keys.evaluate(() => { window.stick[0] = 0; });
for (let i = 0; i < 20; ++i) await keys.keyboard.press('-');
await keys.waitForFunction(() => window.motorAt(performance.now()) === 0, { polling: 10 });
promise('strength 0 is no vibration', await keys.$eval('#strength', strength => strength.value === '0'));
const tree = await keys.accessibility.snapshot({ interestingOnly: true });
const names = JSON.stringify(tree);
promise('each control has a name', ['Pause', 'Sound', 'Full screen', 'Keys and help', 'Position in the film', 'Strength',
  'Sensitivity'].every(name => names.includes(name)) && !/"role":"(button|slider)","name":""/.test(names));
await keys.keyboard.press('?');
await keys.click('#letters');
await keys.keyboard.press('Escape');
await keys.keyboard.press('m');
promise('keys of one character can be switched off', await keys.$eval('video', film => film.muted));
await keys.keyboard.press('F1');
promise('F1 is left', await keys.$eval('#keys', dialog => dialog.open));
await keys.click('#letters');
await keys.keyboard.press('Escape');
await keys.close();

const dark = await open({ scheme: 'dark' });
await dark.click('#begin');
await dark.waitForFunction(() => document.querySelector('video').currentTime > 4);
await dark.mouse.move(530, 300);
await felt(dark);
await dark.evaluate(() => window.unplug());
await dark.waitForFunction(() => /^No gamepad/.test(document.getElementById('status').textContent));
await shoot(dark, 'desktop-dark');
await dark.close();

for (const scheme of ['light', 'dark']) {
  const phone = await open({ width: 390, height: 844, scheme, phone: true });
  await shoot(phone, `phone-${scheme}-begin`);
  await phone.tap('#begin');
  await phone.waitForFunction(() => document.querySelector('video').currentTime > 4);
  const box = await (await phone.$('#stage')).boundingBox();
  await phone.touchscreen.touchStart(box.x + 0.42 * box.width, box.y + 0.42 * box.height);
  await felt(phone);
  await shoot(phone, `phone-${scheme}`);
  await phone.touchscreen.touchEnd();
  await phone.waitForFunction(() => window.motorAt(performance.now()) === 0, { polling: 10 });
  promise(`a finger feels, and no longer when it is lifted (${scheme})`, true);
  promise('nothing is wider than the phone', await phone.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
  await phone.close();
}

for (const scheme of ['light', 'dark']) {
  const checked = await openPage(browser, server.origin, { scheme });
  await checked.setBypassCSP(true);
  await checked.goto(`${server.origin}/`);
  const broken = await brokenRules(checked);
  await checked.evaluate(() => document.getElementById('keys').showModal());
  broken.push(...await brokenRules(checked));
  console.log(broken);
  promise(`no rule of accessibility is broken (${scheme})`, broken.length === 0);
  await checked.close();
}

const side = await open({ width: 844, height: 390, phone: true });
const tall = await side.$eval('#stage', stage => stage.clientHeight);
console.log(`${tall} of 390 px`);
promise('a telephone on its side gives the film its height', tall >= 0.9 * 390);
promise('but for a strip by which a finger scrolls', tall <= 390 - 32);
promise('problems are a list that is announced', await side.$eval('#problems', list => !list.hasAttribute('role')
  && list.parentElement.getAttribute('role') === 'alert'));
await side.close();

const disk = await browser.newPage();
await disk.goto(`file://${web}/index.html`);
await disk.waitForFunction(() => getComputedStyle(document.getElementById('no-script')).visibility === 'visible');
promise('from disk the page says how to serve it, and has no button that does nothing', await disk.evaluate(() =>
  /localhost/.test(document.body.innerText) && document.getElementById('begin').hidden));
await disk.close();

const array = await open({}, '?array=back-3x4');
await array.click('#begin');
await array.waitForFunction(() =>
  /12 actuators, the strongest at [1-9]/.test(document.getElementById('array')?.getAttribute('aria-label')));
await shoot(array, 'array');
await array.click('#play');
await array.waitForFunction(() => / 0 %$/.test(document.getElementById('array').getAttribute('aria-label')));
promise('an array that the address names is shown while the film plays', array.trouble.length === 0);
await array.goto(`${server.origin}/?array=jacket`);
await array.waitForFunction(() => /no array “jacket”/.test(document.getElementById('problems').textContent));
promise('one that is missing is said', true);
await array.close();

const refused = await openPage(browser, server.origin, { width: 390, height: 844, phone: true });
await refused.goto(`${server.origin}/?playlist=https://elsewhere.invalid/film.m3u8`);
await refused.waitForFunction(() => document.getElementById('problems').children.length > 0);
await shoot(refused, 'phone-refused');
await refused.close();

await browser.close();
server.close();
