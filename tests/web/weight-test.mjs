// SPDX-License-Identifier: LGPL-2.1-or-later
// What a browser has to load before the film, as a server compresses it:
//
//   weight-test.mjs WEB-FOLDER
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { promise } from './promise.mjs';

const folder = process.argv[2];
const names = readdirSync(folder).filter(name => /\.(html|css|m?js)$/.test(name));
const read = name => readFileSync(join(folder, name));
const weight = names => names.reduce((sum, name) => sum + gzipSync(read(name)).length, 0);

const isHls = name => name.startsWith('hls.');
const ON_REQUEST = ['array.js']; // the address asks for it
const own = names.filter(name => !isHls(name) && !ON_REQUEST.includes(name));
console.log(`without hls.js ${weight(own)} bytes, with it ${weight(names)}`);
promise('the page weighs at most 30 kB', weight(own) > 10_000 && weight(own) <= 30_000);
promise('and 250 kB with hls.js', weight(names) <= 250_000);

promise('what the address may ask for weighs at most 5 kB, and nothing else loads it', weight(ON_REQUEST) <= 5_000
  && own.every(name => !/from '\.\/array\.js'/.test(read(name))));
for (const name of [...own, ...ON_REQUEST])
  for (const [, file] of read(name).toString().matchAll(/(?:from |src="|href=")'?(?:\.\/)?([\w.-]+\.(?:js|css))['"]/g))
    promise(`${name} finds ${file}`, names.includes(file));
const policy = read('index.html').toString().match(/Content-Security-Policy" content="([^"]*)"/)?.[1];
promise('its policy has no unsafe source and no other host', policy.startsWith("default-src 'none'")
  && !/unsafe|https?:|\*/.test(policy));
