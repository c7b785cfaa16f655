// SPDX-License-Identifier: LGPL-2.1-or-later
// Who has no device: the hand that is blown away, and the force as a sound, as docs/web.md describes them.
//
//   without-device-test.mjs WEB-FOLDER FILM-FOLDER
import { INSECURE, browsers, openBrowser, openPage } from './browser.mjs';
import { promise } from './promise.mjs';
import { serve } from './server.mjs';

const [web, films] = process.argv.slice(2);
const server = await serve([web, films]);
for (const name of browsers()) {
  const browser = await openBrowser(name);
  const page = await openPage(browser, server.origin, { width: 480, height: 420 });
  await page.goto(`${server.origin}/`);

  const blown = await page.evaluate(async () => {
    const { blownBy } = await import('./page/blown-hand.js');
    return [[{ x: 1, y: 0 }, 1], [{ x: 0, y: 0.5 }, 1], [{ x: 3, y: 4 }, 0.5], [{ x: 0, y: 0 }, 1], [{ x: 1, y: 1 }, 0]]
      .map(([force, share]) => blownBy(force, share));
  });
  const isAt = ({ x, y }, [right, down]) => Math.abs(x - right) < 1e-9 && Math.abs(y - down) < 1e-9;
  promise('the hand is blown by force times share, and up by a force upwards', isAt(blown[0], [0.08, 0])
    && isAt(blown[1], [0, -0.04]));
  promise('by 8 % of the height at most, and not at all by no force or share', isAt(blown[2], [0.04 * 0.6, -0.04 * 0.8])
    && isAt(blown[3], [0, 0]) && isAt(blown[4], [0, 0]));

  const cursorIs = cursor => page.waitForFunction(cursor =>
    getComputedStyle(document.getElementById('stage')).cursor === cursor, {}, cursor);
  await cursorIs('crosshair');
  promise('beside a gamepad the hand stays at the pointer', await page.$eval('#blow', blow => blow.disabled));
  await page.evaluate(() => window.unplug());
  await page.waitForFunction(() => !document.getElementById('blow').disabled);
  await cursorIs('crosshair');
  promise('where there is no hand, the mouse is seen', true);
  const { x, y, width, height } = await (await page.$('#stage')).boundingBox();
  await page.mouse.move(x + width / 2, y + height / 2);
  await cursorIs('none');
  promise('without one it is blown, in the place of the pointer of the system', true);
  if (name === 'chromium') { // the driver of Firefox cannot say so
    await page.emulateMediaFeatures([{ name: 'prefers-reduced-motion', value: 'reduce' }]);
    await cursorIs('crosshair');
    promise('not for who wants less motion', true);
    await page.emulateMediaFeatures([]);
  }

  // {peak, left, right: amplitudes, hertz} while each of these forces lasts, from 50 ms after it began.
  const heard = await page.evaluate(async () => {
    const { ForceSound } = await import('./page/force-sound.js');
    const LASTS = 0.25, RATE = 48_000;
    const forces = [{ x: 0, y: 0 }, { x: 0, y: 0.5 }, { x: 0, y: 1 }, { x: 1, y: 0 }, { x: -0.2, y: 0 }, { x: 0, y: -1 },
      { x: 0, y: 0 }];
    const context = new OfflineAudioContext(2, forces.length * LASTS * RATE, RATE);
    const sound = new ForceSound(context);
    for (const [i, force] of forces.entries()) sound.hear(force, i * LASTS);
    const buffer = await context.startRendering();
    return forces.map((_, i) => {
      const [left, right] = [0, 1].map(channel =>
        buffer.getChannelData(channel).subarray((i * LASTS + 0.05) * RATE, (i + 1) * LASTS * RATE));
      const size = samples => Math.sqrt(2 * samples.reduce((sum, value) => sum + value * value, 0) / samples.length);
      const louder = size(left) > size(right) ? left : right;
      const crossings = louder.filter((value, i) => i > 0 && value >= 0 && louder[i - 1] < 0).length;
      return {
        level: Math.hypot(size(left), size(right)), left: size(left), right: size(right),
        silent: [...left, ...right].every(value => value === 0), hertz: crossings / (LASTS - 0.05),
      };
    });
  });
  console.log(heard);
  const decibels = (a, b) => 20 * Math.log10(a / b);
  const [still, half, up, right, left, down, end] = heard;
  promise('no force is digital silence, after a force too', still.silent && end.silent);
  promise('the level is -20 dBFS at 1 N', [up, right, down].every(({ level }) => Math.abs(decibels(level, 0.1)) < 1));
  promise('and follows the force', Math.abs(decibels(half.level, 0.05)) < 1 && Math.abs(decibels(left.level, 0.02)) < 1);
  promise('a force to the right is heard on the right, one to the left on the left',
    right.left < 0.01 * right.right && left.left > left.right);
  promise('a force up is an octave above one to the side, one down an octave below', Math.abs(up.hertz - 660) < 10
    && Math.abs(right.hertz - 330) < 10 && Math.abs(down.hertz - 165) < 10);

  const isHeard = () => page.$eval('#hear', button => button.getAttribute('aria-pressed') === 'true');
  promise('the sound is off until it is asked for', !await isHeard());
  await page.keyboard.press('s');
  promise('S turns it on', await isHeard() && page.trouble.length === 0);
  await page.goto(server.origin.replace('127.0.0.1', INSECURE));
  await page.evaluate(() => window.unplug());
  await page.waitForFunction(() => /https or from localhost/.test(document.getElementById('status').textContent));
  promise('a page that is not secure says why there is no gamepad', await page.evaluate(() => !isSecureContext));
  await browser.close();
}
server.close();
