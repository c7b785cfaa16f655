// SPDX-License-Identifier: LGPL-2.1-or-later
// The player as an npm package: what is in it, and what an embedder's program gets.
//
//   npm-test.mjs WEB-FOLDER VERSION
import { spawnSync } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { promise, skip } from './promise.mjs';

const [web, version] = process.argv.slice(2);
const player = resolve(web, 'player');
const work = mkdtempSync(join(tmpdir(), 'npm-'));
process.on('exit', () => rmSync(work, { recursive: true }));

// ---- what stands in it

const about = JSON.parse(readFileSync(join(player, 'package.json'), 'utf8'));
promise('its version is that of the project', about.version === version);
const modules = readdirSync(player).filter(name => name.endsWith('.js') && !/^hls\.(light|worker)|\.min\./.test(name));
const read = name => readFileSync(join(player, name), 'utf8');
promise('hls.js is imported by ./hls alone',
  modules.filter(name => /['"]hls\.js/.test(read(name))).join() === 'hls.js');
promise('each module is under the MIT licence',
  modules.every(name => read(name).startsWith('// SPDX-License-Identifier: MIT\n')));

// ---- a program with it, without hls.js and without a DOM

const home = join(work, 'node_modules', 'feeling-wind');
mkdirSync(home, { recursive: true });
cpSync(player, home, { recursive: true, filter: path => !path.includes('.p/') });
function runs(name, text) {
  const file = join(work, `${name}.mjs`);
  writeFileSync(file, text);
  const { status, stdout, stderr } = spawnSync(process.execPath, [file], { encoding: 'utf8' });
  console.log(stdout + stderr);
  return status === 0;
}
promise('attach() can be imported without hls.js and without a DOM', runs('plain',
  "import { attach, Problem, Refusal } from 'feeling-wind'; if (!attach || !Problem || !Refusal) process.exit(1);"));
promise('so can the element', runs('element',
  "import { FeelingWind, attach } from 'feeling-wind/element'; if (!FeelingWind || !attach) process.exit(1);"));
// As a bundler of the embedder does.
const bundled = spawnSync('esbuild', ['--bundle', '--format=esm', join(work, 'element.mjs')], { encoding: 'utf8' });
if (!bundled.error) promise('a bundler needs no hls.js either', bundled.status === 0 || console.log(bundled.stderr));
promise('./hls needs hls.js', !runs('poor', "import 'feeling-wind/hls';"));
const hls = join(work, 'node_modules', 'hls.js');
mkdirSync(hls);
writeFileSync(join(hls, 'package.json'), '{ "type": "module", "exports": { "./light": "./light.js" } }');
writeFileSync(join(hls, 'light.js'), 'export default class Hls {}');
promise('and takes that of the embedder', runs('hls',
  "import { attach } from 'feeling-wind/hls'; if (!attach) process.exit(1);"));

// ---- what npm packs

const pack = spawnSync('npm', ['pack', '--dry-run', '--json', '--offline', player], { cwd: work, encoding: 'utf8' });
if (pack.error) skip('npm is not installed');
const files = JSON.parse(pack.stdout)[0].files.map(({ path }) => path);
console.log(files.join(' '));
const needed = Object.values(about.exports).flatMap(({ types, default: file }) => [types.slice(2), file.slice(2)]);
promise('npm packs each file that the package exports', needed.every(name => files.includes(name)
  || name === 'feeling-wind.min.js')); // which a build without esbuild lacks
const imported = files.filter(name => modules.includes(name)).flatMap(name =>
  Array.from(read(name).matchAll(/(?:from |import\()'\.\/([^']+)'/g), ([, file]) => file));
promise('and each that one of them imports', imported.length > 20 && imported.every(name => files.includes(name)));
promise('and the licence', files.includes('LICENSE'));
promise('but not hls.js, nor what is of the build', !files.some(name => /^hls\.(light|worker)|\.p\/|meson/.test(name)));
