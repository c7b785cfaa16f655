// SPDX-License-Identifier: LGPL-2.1-or-later
// Films, tracks and playlists that are wrong: the page says so, asks no other host, and nothing vibrates.
//
//   bad-input-test.mjs WEB-FOLDER FILM-FOLDER     with the films that browser-test.sh makes
import { openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films] = process.argv.slice(2);
const server = await serve([web, films]);
const browser = await openBrowser();

async function open(query, web = server.origin) {
  const page = await openPage(browser, web);
  await page.goto(`${web}/${query}`);
  await page.evaluate(() => {
    const film = document.getElementById('film');
    film.muted = true;
    film.addEventListener('canplay', () => film.play());
  });
  const box = await (await page.$('#stage')).boundingBox();
  await page.mouse.move(box.x + 0.42 * box.width, box.y + 0.42 * box.height);
  return page;
}

const saysSoon = (page, words) => page.waitForFunction(words =>
  document.getElementById('problems').textContent.includes(words), { polling: 50, timeout: 60_000 }, words);
const vibrated = page => page.evaluate(() => window.motor.some(effect => effect.weak > 0));
const vibrates = page => page.waitForFunction(() => window.motor.some(effect => effect.weak > 0), { polling: 50 });
const plays = page => page.waitForFunction(() => document.querySelector('video').currentTime > 3, { timeout: 60_000 });

for (const [query, words] of [
  ['https://elsewhere.invalid/film.m3u8', 'another server, elsewhere.invalid'],
  ['//elsewhere.invalid/film.m3u8', 'another server, elsewhere.invalid'],
  ['javascript:alert(1)//.m3u8', 'begins with javascript:'],
  ['data:application/vnd.apple.mpegurl,%23EXTM3U', 'begins with data:'],
  ['http://[', 'is no address'],
  ['part-elsewhere.m3u8', 'another server, elsewhere.invalid'],
  ['key-elsewhere.m3u8', 'another server, elsewhere.invalid'],
  ['list-elsewhere.m3u8', 'another server, elsewhere.invalid'],
  ['missing.m3u8', 'The playlist cannot be loaded (404)'],
  ['noise.m3u8', 'it is no HLS playlist'],
  ['part-missing.m3u8', 'A part of the film cannot be loaded (404)'],
]) {
  const page = await open(`?playlist=${encodeURIComponent(query)}`);
  await saysSoon(page, words);
  promise(`${query}: “${words}”`, true);
  promise('nothing vibrates and no other host is asked', !await vibrated(page) &&
    (page.trouble.length === 0 || console.log(page.trouble)));
  await page.close();
}

const bare = await open('?playlist=no-track.m3u8');
await plays(bare);
await saysSoon(bare, 'This film has no haptic track');
promise('a film without a track plays, and the page says so', !await vibrated(bare));
await bare.close();

const alone = await open('?playlist=track-only.m3u8');
await saysSoon(alone, 'neither picture nor sound');
promise('a track without a film is no film, and the page says so', !await vibrated(alone));
await alone.close();

const damaged = await open('?playlist=damaged.m3u8');
await plays(damaged);
promise('a damaged film plays on, and its track is felt where it is whole', await vibrates(damaged));
promise('no error reaches the page', damaged.trouble.length === 0 || console.log(damaged.trouble));
await damaged.close();

// Another server gives the page without hls.js.
const poor = await serve([process.argv[4], films]);
const without = await open('', poor.origin);
await saysSoon(without, 'This film needs hls.js');
promise('without hls.js the page says what is missing', true);
await without.close();
const plain = await open('?playlist=cmaf.m3u8', poor.origin);
await plays(plain);
promise('but it plays and feels CMAF', await vibrates(plain) && plain.trouble.length === 0);
await plain.evaluate(() => { document.querySelector('video').currentTime = 15; });
await plain.waitForFunction(() => document.querySelector('video').currentTime > 16 && window.motorAt(performance.now()) > 0);
promise('after a seek, too', await plain.$eval('#problems', problems => problems.textContent === ''));
await plain.close();
const refused = await open('?playlist=map-elsewhere.m3u8', poor.origin);
await saysSoon(refused, 'another server, elsewhere.invalid');
promise('of its own server only', refused.trouble.length === 0);
poor.close();

const cmaf = await open('?playlist=cmaf.m3u8');
await plays(cmaf);
promise('CMAF is felt with hls.js', await vibrates(cmaf) && cmaf.trouble.length === 0);
await cmaf.close();

await browser.close();
server.close();
