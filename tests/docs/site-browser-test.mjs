// SPDX-License-Identifier: LGPL-2.1-or-later
// A built site in Chromium: what its first page weighs, what its pages ask for, whether they fit a telephone, and
// whether everybody can use them.
//
//   site-browser-test.mjs SITE [PAGE...]    without PAGE, all of them
import { readdirSync } from 'node:fs';
import { gzipSync } from 'node:zlib';
import { brokenRules, openBrowser, openPage } from '../web/browser.mjs';
import { promise } from '../web/promise.mjs';
import { serve } from '../web/server.mjs';

const [site, ...some] = process.argv.slice(2);
const MOST = 1_000_000, NARROW = 360; // bytes before the film; px
const pages = some.length ? some : readdirSync(site, { recursive: true }).filter(name => name.endsWith('.html')).sort();
const server = await serve([site]);
const browser = await openBrowser();

// Opens a page and waits until nothing is loaded any more. `bytes` counts what a server sends that compresses text.
async function open(name, options) {
  const page = await openPage(browser, server.origin, options);
  page.bytes = 0;
  page.on('response', async response => {
    const url = response.url();
    if (url.startsWith('data:')) return;
    const content = await response.buffer().catch(() => Buffer.alloc(0)); // none of a redirection
    page.bytes += /\.(html|css|js|json)$/.test(url) ? gzipSync(content).length : content.length;
  });
  await page.goto(`${server.origin}/${name}`, { waitUntil: 'networkidle0' });
  return page;
}

const first = await open('index.html');
console.log(`the first page is ${first.bytes} bytes`);
promise('the first page is at most 1 MB before its film plays', first.bytes <= MOST);
promise('it has four tiles', (await first.$$('.tiles a')).length === 4);
await first.evaluate(() => document.querySelector('feeling-wind').video.play());
const box = await (await first.$('feeling-wind video')).boundingBox();
await first.mouse.move(box.x + 0.165 * box.width, box.y + 0.565 * box.height);
await first.waitForFunction(() => {
  const { x, y } = document.querySelector('feeling-wind').player.force;
  return Math.hypot(x, y) > 0.05; // N
}, { polling: 'raf' });
promise('its film is felt', true);
promise('it asks no other host for anything', first.trouble.length === 0);
await first.close();

const wide = [], broken = [], trouble = [];
for (const name of pages) {
  const page = await open(name, { width: NARROW, height: 740 });
  const width = await page.evaluate(() => document.scrollingElement.scrollWidth);
  if (width > NARROW) wide.push(`${name}: ${width} px`);
  await page.setViewport({ width: 1280, height: 900 });
  for (const scheme of ['default', 'slate']) { // the theme's names of light and dark
    await page.evaluate(scheme => {
      document.body.dataset.mdColorScheme = scheme;
      return Promise.all(document.getAnimations().map(({ finished }) => finished)); // the colours of links fade
    }, scheme);
    broken.push(...(await brokenRules(page)).map(rule => `${name}, ${scheme}: ${rule}`));
  }
  trouble.push(...page.trouble);
  await page.close();
}
console.log([...wide, ...broken, ...trouble].join('\n'));
promise(`${pages.length} pages fit into ${NARROW} px`, wide.length === 0);
promise('no rule of accessibility is broken, in light and in dark', broken.length === 0);
promise('no page asks another host for anything', trouble.length === 0);
await browser.close();
server.close();
