// SPDX-License-Identifier: LGPL-2.1-or-later
// The folder of `haptic-track package --single`, in each browser that is there: under the policy of docs/web.md, in the
// frame of another origin, and from disk.
//
//   element-test.mjs FOLDER [MEDIA]     MEDIA: a further source of media that the policy allows
import { brokenRules, browsers, openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';
import { createServer } from 'node:http';

const [folder, media = ''] = process.argv.slice(2);
const POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
  + `worker-src 'self'; media-src 'self' blob: ${media}`;
const LEAST = 0.01; // N
const TREE = { x: 0.42, y: 0.42 }, SKY = { x: 0.8, y: 0.08 };

const server = await serve([folder], new Set(), { 'content-security-policy': POLICY });
// A page of another origin, which embeds the film.
const artist = createServer(({ url }, response) => response.writeHead(200, { 'content-type': 'text/html' })
  .end(`<!DOCTYPE html><iframe src="${server.origin}/" width="440" height="400" `
    + `allow="${url === '/without' ? "gamepad 'none'" : 'gamepad'}; autoplay"></iframe>`));
await new Promise(ready => artist.listen(0, '127.0.0.1', ready));

// The mean force at a place from 2 to 5 s of the film.
const feel = (page, place) => page.evaluate(async place => {
  await customElements.whenDefined('feeling-wind');
  const film = document.querySelector('feeling-wind');
  const { video, player } = film;
  const forces = [];
  const listen = ({ detail }) => { if (detail.time > 2 && detail.time < 5) forces.push(detail.newtons); };
  film.addEventListener('force', listen);
  player.alpha = 0.04;
  player.place = place;
  video.muted = true;
  video.currentTime = 1.5;
  await video.play();
  await new Promise(done => video.addEventListener('timeupdate', () => video.currentTime > 5 && done()));
  video.pause();
  film.removeEventListener('force', listen);
  return {
    newtons: forces.reduce((sum, newtons) => sum + newtons, 0) / forces.length,
    problems: film.shadowRoot.querySelector('[role=alert]').textContent,
    arrow: film.shadowRoot.querySelector('canvas').width > 300,
  };
}, place);

// The strongest of three: other work may delay the browser, and a film that stands still is not felt.
async function feelTree(page) {
  let felt;
  for (let attempt = 0; attempt < 3 && !(felt?.newtons > LEAST); ++attempt) felt = await feel(page, TREE);
  return felt;
}

for (const name of browsers()) {
  const browser = await openBrowser(name);
  const page = await openPage(browser, server.origin, { width: 480, height: 420 }); // little to draw
  await page.goto(`${server.origin}/`);
  const tree = await feelTree(page), sky = await feel(page, SKY);
  console.log(name, tree, sky, page.trouble);
  promise(`${name}: one file beside the film is felt where it moves`,
    tree.newtons > LEAST && !(sky.newtons > tree.newtons / 2)); // clouds move, too
  promise('nothing is refused by a strict policy, and nothing is wrong',
    page.trouble.length === 0 && tree.problems === '');
  promise('the force is drawn', tree.arrow);
  const box = await (await page.$('feeling-wind')).boundingBox();
  await page.mouse.move(box.x + 0.42 * box.width, box.y + 0.42 * box.height);
  promise('the mouse is the hand', await page.evaluate(() =>
    Math.abs(document.querySelector('feeling-wind').player.place.x - 0.42) < 0.02));
  await page.focus('feeling-wind');
  await page.keyboard.press('ArrowRight');
  promise('so are the arrow keys', await page.evaluate(() =>
    document.querySelector('feeling-wind').player.place.x > 0.43));
  await page.keyboard.press('Escape');
  promise('until Escape', await page.evaluate(() => document.querySelector('feeling-wind').player.place === null));
  const presses = async button => {
    await page.mouse.down({ button });
    const pressed = await page.evaluate(() => document.querySelector('feeling-wind').player.pressed);
    await page.mouse.up({ button });
    return pressed;
  };
  await page.evaluate(() => { document.querySelector('feeling-wind').video.controls = false; }); // Firefox keeps theirs
  promise('the left button presses, and no other', await presses('left') && !await presses('right'));
  const second = await page.evaluate(async place => {
    const { video, player } = document.querySelector('feeling-wind');
    const forces = [];
    player.addEventListener('force', ({ detail }) => forces.push(detail));
    const time = at => new Promise(done => video.addEventListener('timeupdate', () => at(video.currentTime) && done()));
    player.place = place;
    video.loop = true;
    video.currentTime = video.duration - 1;
    await video.play();
    await time(now => now < 5);
    forces.length = 0;
    await time(now => now > 4 && now < 6);
    video.pause();
    const most = key => Math.max(...forces.map(force => force[key]));
    return { newtons: most('newtons'), until: most('time') };
  }, TREE);
  console.log(name, 'second round', second);
  promise('a film that begins again is felt, at its own time', second.newtons > LEAST && second.until < 7);
  await page.evaluate(() => document.querySelector('feeling-wind').setAttribute('src', 'missing.mp4'));
  promise('a film that is missing is said', await page.waitForFunction(() => /cannot be played/.test(
    document.querySelector('feeling-wind').shadowRoot.querySelector('[role=alert]').textContent)));
  promise('a film that is refused is said in the words of the page, as an event, too', await page.evaluate(async () => {
    const element = document.querySelector('feeling-wind'), told = [];
    element.addEventListener('problem', ({ detail, code }) => told.push(detail, code));
    element.texts = { 'origin-refused': 'Nicht von {host}.' };
    element.setAttribute('src', 'http://elsewhere.example/film.m3u8');
    await new Promise(done => setTimeout(done, 100));
    const shown = element.shadowRoot.querySelector('[role=alert]').textContent;
    return told.join() === 'Nicht von elsewhere.example.,origin-refused' && shown === told[0];
  }));
  promise('an element that is removed lets go', await page.evaluate(() => {
    const element = document.querySelector('feeling-wind');
    element.remove();
    return element.player === null;
  }));

  await page.goto(`http://127.0.0.1:${artist.address().port}/`);
  const frame = await (await page.waitForSelector('iframe')).contentFrame();
  const framed = await feelTree(frame);
  console.log(name, 'framed', framed);
  promise('in a frame of another origin it is felt, too', framed.newtons > LEAST && framed.problems === '');

  const plain = await browser.newPage(); // with the gamepads of the browser itself
  await plain.goto(`http://127.0.0.1:${artist.address().port}/without`);
  const closed = await (await plain.waitForSelector('iframe')).contentFrame();
  const drawn = await feelTree(closed);
  console.log(name, 'framed without gamepads', drawn);
  const isRefused = await closed.evaluate(() => {
    try {
      return !navigator.getGamepads();
    } catch {
      return true;
    }
  });
  promise('where the frame may have no gamepad, the force is still drawn', isRefused && drawn.newtons > LEAST);
  await plain.close();

  await page.goto(`file://${folder}/index.html`);
  promise('from disk it says how to serve it', await page.waitForFunction(() =>
    /localhost/.test(document.body.innerText + document.querySelector('feeling-wind')?.shadowRoot?.textContent)));
  for (const scheme of name === 'chromium' ? ['light', 'dark'] : []) {
    const checked = await openPage(browser, server.origin, { scheme });
    await checked.setBypassCSP(true);
    await checked.goto(`${server.origin}/`);
    await checked.waitForFunction(() => document.querySelector('feeling-wind').shadowRoot);
    // A stranger's page breaks rules of its own.
    const broken = await brokenRules(checked, await checked.$('main') ? 'html' : 'feeling-wind');
    console.log(broken);
    promise(`no rule of accessibility is broken (${scheme})`, broken.length === 0);
    await checked.close();
  }
  await browser.close();
}
server.close();
artist.close();
