// SPDX-License-Identifier: LGPL-2.1-or-later
// The player in the page of another: several films in turn, a seek before anything is there, the end, detach().
//
//   embed-test.mjs WEB-FOLDER FILM-FOLDER WEB-FOLDER-WITHOUT-HLS     with the films that browser-test.sh makes
import { readFileSync } from 'node:fs';
import { openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films, poorWeb] = process.argv.slice(2);
const servers = [await serve([web, films]), await serve([poorWeb, films])];
const browser = await openBrowser();

// A page with a muted video and a player on it, which begin() has prepared.
async function attachTo(server, playlist, begin = () => {}, isInstance = false) {
  const page = await openPage(browser, server.origin);
  await page.goto(`${server.origin}/blank.html`);
  await page.evaluate(`window.begin = ${begin}`);
  await page.evaluate(async (playlist, isInstance) => {
    const { attach } = await import('./player/player.js');
    const { default: Hls } = await import('./player/hls.light.min.js');
    const hls = isInstance ? window.hls = new Hls() : Hls;
    const film = document.querySelector('video');
    window.film = film;
    window.problems = [];
    film.muted = true;
    film.addEventListener('canplay', () => film.play());
    window.begin(film);
    window.player = attach(film, { playlist, hls, alpha: 0.04, onProblem: sentence => window.problems.push(sentence) });
    window.player.place = { x: 0.42, y: 0.42 };
  }, playlist, isInstance);
  return page;
}
const until = (page, condition) => page.waitForFunction(condition, { polling: 20, timeout: 60_000 });
const isFelt = () => window.motorAt(performance.now()) > 0;

const early = await attachTo(servers[0], 'film.m3u8', film => { film.currentTime = 10; });
await until(early, isFelt);
promise('a film that begins later has a track', await early.evaluate(() => window.problems.length === 0));
promise('the player has what player.d.ts says', await early.evaluate(names =>
  names.length > 8 && names.every(name => name in window.player),
Array.from(readFileSync(`${web}/player/player.d.ts`, 'utf8').match(/interface Player [^{]*\{([^]*?)\n\}/)[1]
  .matchAll(/^ {2}(?:readonly )?(\w+)[(:]/gm), ([, name]) => name)));
await early.evaluate(() => window.player.load('no-track.m3u8'));
promise('another film is not felt by the track of the first', await early.evaluate(() => !window.player.hasTrack));
await until(early, () => window.problems.some(problem => problem.startsWith('This film has no haptic track')));
await early.evaluate(() => window.player.load('film.m3u8'));
await until(early, isFelt);
promise('and the first is felt again', early.trouble.length === 0);
await early.close();

const own = await attachTo(servers[0], 'film.m3u8', () => {}, true);
await until(own, isFelt);
await own.evaluate(() => window.player.detach());
promise('an instance of hls.js of the page is used, and given back', await own.evaluate(() =>
  window.hls.url.endsWith('film.m3u8') && window.hls.media === null));
await own.close();

for (const [i, what] of ['with hls.js', 'without hls.js'].entries()) {
  const page = await attachTo(servers[i], 'packaged/film.m3u8',
    film => film.addEventListener('loadedmetadata', () => { film.currentTime = film.duration; }, { once: true }));
  await until(page, () => window.film.ended);
  promise(`a seek to the end before anything is there is the end, ${what}`, true);
  await page.evaluate(() => {
    window.film.currentTime = 0;
    window.film.playbackRate = 8;
    window.film.play();
  });
  await until(page, () => window.film.currentTime > 0.1 && window.film.currentTime < 15);
  await until(page, () => window.film.ended);
  promise('from the beginning, too', await page.evaluate(() => window.problems.length === 0 && window.film.duration > 19));
  await page.evaluate(() => {
    window.film.currentTime = 5;
    window.film.playbackRate = 1;
    window.film.play();
  });
  await until(page, isFelt);
  await page.evaluate(() => window.player.detach());
  promise('detach() is zero and lets go of the video', await page.evaluate(() =>
    window.motorAt(performance.now()) === 0 && window.film.readyState === 0 && !window.film.getAttribute('src')));
  await page.close();
}

await browser.close();
for (const server of servers) server.close();
