// SPDX-License-Identifier: LGPL-2.1-or-later
// Chromium for the tests of the page, by puppeteer-core from the folder of npm's packages in WEB_PACKAGES.
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { skip } from './promise.mjs';
import { installGamepad } from './gamepad.mjs';

function findPuppeteer() {
  try {
    return createRequire(`${process.env.WEB_PACKAGES}/`)('puppeteer-core');
  } catch {
    return skip('puppeteer-core is not there (npm ci of pipelines/web/package.json)');
  }
}

export async function openBrowser() {
  const executablePath = ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find(existsSync);
  if (!executablePath) skip('chromium is not installed');
  return findPuppeteer().launch({
    executablePath,
    args: ['--no-sandbox', '--autoplay-policy=no-user-gesture-required', '--mute-audio', '--disable-dev-shm-usage'],
    protocolTimeout: 240_000,
  });
}

/** A page with a gamepad. `page.trouble` lists other hosts that it asked for and its errors. */
export async function openPage(browser, origin, { width = 1280, height = 900, scheme = 'light', phone = false } = {}) {
  const page = await browser.newPage();
  await page.setViewport({ width, height, hasTouch: phone, isMobile: phone, deviceScaleFactor: phone ? 2 : 1 });
  await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
  await page.evaluateOnNewDocument(installGamepad);
  page.trouble = [];
  page.on('request', request => {
    if (!request.url().startsWith(origin) && !/^(blob|data):/.test(request.url())) page.trouble.push(request.url());
  });
  page.on('pageerror', error => page.trouble.push(String(error)));
  page.on('console', message => {
    if (/Content Security Policy/.test(message.text())) page.trouble.push(message.text());
  });
  return page;
}
