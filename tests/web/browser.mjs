// SPDX-License-Identifier: LGPL-2.1-or-later
// Chromium and Firefox for the tests of the page, by puppeteer-core from the folder of npm's packages in WEB_PACKAGES.
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { delimiter, join } from 'node:path';
import { skip } from './promise.mjs';
import { installGamepad } from './gamepad.mjs';

function findPackage(name) {
  try {
    return createRequire(`${process.env.WEB_PACKAGES}/`)(name);
  } catch {
    return skip(`${name} is not there (npm ci of pipelines/web/package.json)`);
  }
}

/** A name of this computer that makes a page of http no secure context. */
export const INSECURE = 'films.example';

const OPTIONS = {
  chromium: {
    args: ['--no-sandbox', '--autoplay-policy=no-user-gesture-required', '--mute-audio', '--disable-dev-shm-usage',
      `--host-resolver-rules=MAP ${INSECURE} 127.0.0.1`],
  },
  firefox: {
    browser: 'firefox',
    extraPrefsFirefox: { 'media.autoplay.default': 0, 'media.autoplay.blocking_policy': 0, 'media.volume_scale': '0.0',
      'network.dns.localDomains': INSECURE },
  },
};
const NAMES = { chromium: ['chromium', 'chromium-browser'], firefox: ['firefox-esr', 'firefox'] };

function find(name) {
  const folders = process.env.PATH.split(delimiter);
  return NAMES[name].flatMap(name => folders.map(folder => join(folder, name))).find(existsSync);
}

/** `name` is chromium or firefox. */
export async function openBrowser(name = 'chromium') {
  const executablePath = find(name);
  if (!executablePath) skip(`${name} is not installed`);
  const browser = await findPackage('puppeteer-core').launch({ executablePath, protocolTimeout: 240_000, ...OPTIONS[name] });
  process.on('exit', () => browser.process()?.kill('SIGKILL'));
  return browser;
}

/** The browsers of `chromium` and `firefox` that are there. */
export const browsers = () => Object.keys(OPTIONS).filter(find);

/** A page with a gamepad. `page.trouble` lists other hosts that it asked for and its errors. */
export async function openPage(browser, origin, { width = 1280, height = 900, scheme = 'light', phone = false } = {}) {
  const page = await browser.newPage();
  if (phone) await page.setViewport({ width, height, hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
  else await page.setViewport({ width, height });
  if (scheme !== 'light') await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
  await page.evaluateOnNewDocument(installGamepad);
  page.trouble = [];
  page.on('request', request => {
    if (!request.url().startsWith(origin) && !/^(blob|data):/.test(request.url())) page.trouble.push(request.url());
  });
  page.on('response', response => {
    const url = response.url();
    if (response.status() >= 400 && url.endsWith('.js')) page.trouble.push(`${response.status()} ${url}`);
  });
  page.on('pageerror', error => page.trouble.push(String(error)));
  page.on('console', message => {
    if (/Content Security Policy/.test(message.text())) page.trouble.push(message.text());
  });
  return page;
}

/** The rules of accessibility (axe-core) that an open page breaks, or a part of it. Its policy has to be bypassed. */
export function brokenRules(page, part = 'html') {
  return page.evaluate(`${findPackage('axe-core').source}; axe.run('${part}').then(({ violations }) =>
    violations.map(({ id, nodes }) => id + ': ' + nodes[0].html))`);
}
