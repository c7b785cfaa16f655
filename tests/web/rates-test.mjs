// SPDX-License-Identifier: LGPL-2.1-or-later
// The same film at several speeds, in each browser that is there: the same force, without a gap.
//
//   rates-test.mjs WEB-FOLDER FILM-FOLDER [SECONDS]     of the film, 5 unless said; with cmaf.m3u8 of browser-test.sh
import { browsers, openBrowser, openPage } from './browser.mjs';
import { expectedForces, isFelt } from './expected-force.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films, seconds = '5'] = process.argv.slice(2);
const RATES = [1, 0.75, 0.5];
const FROM = 2, UNTIL = FROM + Number(seconds); // s of the film
const WITHIN = 0.02; // of the force
const ALPHA = 0.04; // s/px
const PLACE = { x: 0.42, y: 0.42 };

const server = await serve([web, films]);

function feel(page, rate) {
  return page.evaluate(async (rate, alpha, place, until) => {
    const { attach } = await import('./player/player.js');
    const film = document.querySelector('video');
    film.muted = true;
    const forces = [];
    const player = attach(film, {
      playlist: 'cmaf.m3u8', alpha, onForce: ({ time, newtons }) => forces.push([time, newtons]),
    });
    player.place = place;
    await new Promise(done => film.addEventListener('canplay', done, { once: true }));
    film.playbackRate = rate;
    await film.play();
    await new Promise(done => film.addEventListener('timeupdate', () => film.currentTime > until + 0.5 && done()));
    player.detach();
    return forces;
  }, rate, ALPHA, PLACE, UNTIL);
}

// The mean force from FROM to UNTIL.
function meanOf(forces) {
  const felt = forces.filter(([time]) => time >= FROM && time <= UNTIL);
  const areas = felt.slice(1).map(([time, newtons], i) => (time - felt[i][0]) * (newtons + felt[i][1]) / 2);
  return areas.reduce((sum, area) => sum + area, 0) / (UNTIL - FROM);
}

for (const name of browsers()) {
  const browser = await openBrowser(name);
  const page = await openPage(browser, server.origin);
  for (const rate of RATES) {
    const expected = expectedForces(`${films}/cmaf-film.m4s`, { place: PLACE, alpha: ALPHA, until: UNTIL, rate });
    // One of three: other work may delay the browser.
    let share, drops;
    for (let attempt = 0; attempt < 3; ++attempt) {
      await page.goto(`${server.origin}/blank.html`);
      const forces = await feel(page, rate);
      drops = forces.filter(([time, newtons]) =>
        time > FROM && time < UNTIL && newtons === 0 && isFelt(expected, time)).length;
      share = meanOf(forces) / meanOf(expected);
      console.log(`${name} at ${rate}: ${(100 * share).toFixed(1)} % of ${meanOf(expected).toFixed(4)} N, the force of `
        + `the track; ${drops} drops in ${UNTIL - FROM} s of the film`);
      if (drops === 0 && Math.abs(share - 1) < WITHIN) break;
    }
    promise(`${name} at ${rate} times the speed never drops the force`, drops === 0);
    promise('and it is that of the track', Math.abs(share - 1) < WITHIN);
  }
  await browser.close();
}
server.close();
