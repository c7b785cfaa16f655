// SPDX-License-Identifier: LGPL-2.1-or-later
// The lines that docs/web.md shows, as they stand there and under its policies, in each browser that is there.
//
//   lines-test.mjs WEB-FOLDER FOLDER-OF-ELEMENT PACKAGED-FOLDER [SHAKA.js]
//
// Without SHAKA.js, a file of shaka-player, the lines for Shaka Player are left out.
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { browsers, openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, element, packaged, shaka] = process.argv.slice(2);
const PLACE = { x: 0.42, y: 0.42 }; // where the film moves
const LEAST = 0.01; // N

const text = readFileSync(new URL('../../docs/web.md', import.meta.url), 'utf8');
const blocks = Array.from(text.matchAll(/^```(\w+)\n([^]*?)^```$/gm), ([, language, lines]) => ({ language, lines }));
const linesOf = (language, word) =>
  blocks.find(block => block.language === language && block.lines.includes(word)).lines;
const [own, embedded] = blocks.filter(({ language }) => language === 'nginx')
  .map(({ lines }) => lines.match(/Content-Security-Policy "([^"]*)"/)[1]);
const iframe = linesOf('html', '<iframe');
promise('before all else the page says that gamepads need https',
  /https/.test(text.slice(0, text.indexOf('\n## '))) && /gamepad/i.test(text.slice(0, text.indexOf('\n## '))));

const work = mkdtempSync(join(tmpdir(), 'lines-'));
process.on('exit', () => rmSync(work, { recursive: true }));
const page = linesOf('html', '<video');
const files = {
  'blank.html': '<!DOCTYPE html><title>A page</title>',
  'element.html': linesOf('html', '<feeling-wind'),
  'video.html': page, 'film.js': linesOf('js', 'onpointermove'),
  'hold.html': page.replace('film.js', 'hold.js'), 'hold.js': linesOf('js', 'new Hold'),
  // A video of the page in the element, which two files define.
  'slot.html': `<script type="module" src="feeling-wind.min.js"></script>
    <script type="module" src="player/element.js"></script>
    <feeling-wind track="film.klv"><video src="film.mp4"></video></feeling-wind>`,
  'shaka.html': `<video id="film" muted></video><script src="shaka-player.js"></script>
    <script type="module" src="shaka.js"></script>`,
  // What the lines take for granted: `attach`, `film` and Shaka's player.
  'shaka.js': `import { attach } from './player/player.js';
    const film = document.getElementById('film');
    const shakaPlayer = new shaka.Player();
    await shakaPlayer.attach(film);
    ${linesOf('js', 'shakaPlayer')}
    window.player = player;
    await shakaPlayer.load('film.m3u8');`,
};
for (const [name, lines] of Object.entries(files)) writeFileSync(join(work, name), lines);
if (shaka) copyFileSync(shaka, join(work, 'shaka-player.js'));

const site = await serve([work, element, web, packaged], new Set(), { 'content-security-policy': own });
const films = await serve([packaged], new Set(), { 'content-security-policy': own });
const open = await serve([packaged, element], new Set(),
  { 'content-security-policy': embedded, 'access-control-allow-origin': '*' });
for (const { origin } of [films, open])
  writeFileSync(join(work, `${new URL(origin).port}.html`), iframe.replace('https://films.example/film', origin));
const artist = await serve([work, web]); // a page of another origin, without a policy

// Whether a force is felt at PLACE while the film of the page or frame plays; `player` says where the page has it.
const isFelt = (page, player) => page.evaluate(async (player, place, least) => {
  const { video = document.querySelector('video'), player: own } = document.querySelector('feeling-wind') ?? {};
  const felt = own ?? window[player];
  felt.place = place;
  felt.alpha = 0.04;
  video.muted = true;
  await video.play();
  return new Promise(done => felt.addEventListener('force', ({ detail }) => detail.newtons > least && done(true)));
}, player, PLACE, LEAST);

for (const name of browsers()) {
  const browser = await openBrowser(name);
  const visit = async (origin, file) => {
    const page = await openPage(browser, origin, { width: 480, height: 420 });
    await page.goto(`${origin}/${file}`);
    return page;
  };
  const first = await visit(site.origin, 'element.html');
  await first.waitForFunction(() => document.querySelector('feeling-wind')?.player);
  promise(`${name}: the two lines of a page are felt`, await isFelt(first) && first.trouble.length === 0);
  await first.close();

  const slot = await visit(site.origin, 'slot.html');
  await slot.waitForFunction(() => document.querySelector('feeling-wind')?.player);
  promise('so is a video in the element', await isFelt(slot) && slot.trouble.length === 0
    && await slot.evaluate(() => document.querySelector('feeling-wind').video === document.querySelector('video')));
  await slot.close();

  const second = await visit(site.origin, 'video.html');
  const forces = [];
  second.on('console', message => {
    const [, x, y] = message.text().split(' ').map(Number);
    if (Math.hypot(x, y) > LEAST) forces.push(Math.hypot(x, y));
  });
  promise('a viewer can play the film of attach()', await second.$eval('video', film => film.controls));
  promise('the policy for nginx refuses nothing of it', second.trouble.length === 0);
  await second.waitForFunction(() => document.querySelector('video').readyState >= 3);
  const box = await (await second.$('video')).boundingBox();
  await second.$eval('video', film => film.play());
  for (let i = 0; forces.length === 0 && i < 300; ++i) {
    await second.mouse.move(box.x + PLACE.x * box.width + i % 2, box.y + PLACE.y * box.height);
    await new Promise(done => setTimeout(done, 100));
  }
  console.log(forces, second.trouble);
  promise('and feel it with the mouse', forces.length > 0 && second.trouble.length === 0);
  await second.close();

  const third = await visit(site.origin, 'hold.html');
  await third.waitForFunction(() => document.querySelector('video').onmousedown);
  promise('the lines that hold are run', third.trouble.length === 0);
  await third.close();

  if (shaka) {
    const fourth = await visit(site.origin, 'shaka.html');
    await fourth.waitForFunction(() => window.player && document.querySelector('video').readyState >= 3);
    promise('a film in Shaka Player is felt', await isFelt(fourth, 'player') && fourth.trouble.length === 0);
    await fourth.close();
  }

  // The page in the frame of another site, by the lines for it.
  const frameOf = async ({ origin }) => {
    const page = await visit(artist.origin, `${new URL(origin).port}.html`);
    return (await page.waitForSelector('iframe')).contentFrame();
  };
  const isShown = frame => frame.$('#stage').then(Boolean, () => false); // frames are loaded before visit() ends
  const frame = await frameOf(open);
  promise('another site may embed the page', await isShown(frame));
  await frame.waitForFunction(() => document.querySelector('video')?.readyState >= 3);
  await frame.evaluate(async () => {
    for (const key of ['ArrowLeft', 'ArrowUp'])
      document.dispatchEvent(new KeyboardEvent('keydown', { key, shiftKey: true }));
    const film = document.querySelector('video');
    film.muted = true;
    await film.play();
  });
  promise('where it is felt', await frame.waitForFunction(() =>
    parseFloat(document.getElementById('newtons').textContent) > 0.02));
  promise('but not with the policy for an own page', !await isShown(await frameOf(films)));

  // A film of another server: refused, unless its origin is allowed.
  const last = await visit(artist.origin, 'blank.html');
  await last.setContent(`<video src="${open.origin}/film.mp4" muted></video>`);
  const codes = await last.evaluate(async (web, films) => {
    const { attach } = await import(`${web}/player/player.js`);
    const film = document.querySelector('video'), codes = [];
    const options = { track: `${films}/film.klv`, onProblem: (_, code) => codes.push(code) };
    attach(film, options).detach();
    await new Promise(done => setTimeout(done));
    window.player = attach(film, { ...options, allowedOrigins: [films] });
    return codes;
  }, artist.origin, open.origin);
  promise('a track of another server is refused', codes.join() === 'origin-refused');
  promise('unless the page allows its origin', await isFelt(last, 'player'));
  await browser.close();
}
for (const server of [site, films, open, artist]) server.close();
