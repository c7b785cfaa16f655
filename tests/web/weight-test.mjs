// SPDX-License-Identifier: LGPL-2.1-or-later
// What a browser has to load before the film, as a server compresses it:
//
//   weight-test.mjs WEB-FOLDER
import { spawnSync } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import { basename, dirname, join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { promise } from './promise.mjs';

const folder = process.argv[2];
const names = readdirSync(folder, { recursive: true }).filter(name => /\.(html|css|m?js)$/.test(name));
const read = name => readFileSync(join(folder, name));
const weight = names => names.reduce((sum, name) => sum + gzipSync(read(name)).length, 0);

const isHls = name => basename(name).startsWith('hls.');
const ON_REQUEST = ['page/array.js', 'page/force-sound.js']; // the address, or a key, asks for it
const WITH_RELIEFS = ['player/touch.js', 'player/contact.js', 'page/relief-page.js']; // the first relief does
const WITH_PLAY = ['player/field-hold.js', 'player/hold.js', 'page/hold-page.js']; // the film that plays does
const WITHOUT_HLS = ['player/plain-hls.js']; // what plays the film then
const BUNDLE = 'player/feeling-wind.min.js';
const ELSEWHERE = ['single.html', 'player/element.js', 'player/hls.js', BUNDLE]; // what other pages load
const later = [...ON_REQUEST, ...WITH_RELIEFS, ...WITH_PLAY, ...WITHOUT_HLS];
const own = names.filter(name => !isHls(name) && ![...later, ...ELSEWHERE].includes(name));
const bare = [...own, ...WITHOUT_HLS];
console.log(`without hls.js ${weight(bare)} bytes, with it ${weight(names)}; of a film that can be touched ${weight(WITH_RELIEFS)} more; `
  + `to hold, once it plays, ${weight(WITH_PLAY)}`);
promise('the page weighs at most 30 kB', weight(bare) > 10_000 && weight(bare) <= 30_000);
promise('and 250 kB with hls.js', weight(names.filter(name => !ELSEWHERE.includes(name))) <= 250_000);
if (names.includes(BUNDLE)) {
  console.log(`the element in one file ${weight([BUNDLE])} bytes`);
  promise('the element in one file weighs at most 30 kB', weight([BUNDLE]) <= 30_000);
  promise('and keeps its notice', read(BUNDLE).toString().startsWith('/*! Feeling Wind'));
}

promise('what the address may ask for weighs at most 5 kB', weight(ON_REQUEST) > 1_000 && weight(ON_REQUEST) <= 5_000);
promise('what a relief needs weighs at most 8 kB', weight(WITH_RELIEFS) > 4_000 && weight(WITH_RELIEFS) <= 8_000);
promise('what holding needs weighs at most 5 kB', weight(WITH_PLAY) > 1_000 && weight(WITH_PLAY) <= 5_000);
const FILE = /'?((?:\.{1,2}\/)*(?:[\w-]+\/)?[\w.-]+\.(?:js|css))['"]/.source;
const filesIn = (name, before) =>
  Array.from(read(name).toString().matchAll(new RegExp(before + FILE, 'g')), ([, file]) => join(dirname(name), file));
const isHlsOr = list => file => isHls(file) || list.includes(file);
for (const name of [...own, ...later]) {
  const atOnce = filesIn(name, '(?:from |src="|href=")');
  for (const file of atOnce) promise(`${name} finds ${file}`, names.includes(file));
  promise(`${name} loads nothing at once that is for later`, !own.includes(name) || !atOnce.some(file => later.includes(file)));
  promise(`${name} finds what it loads later`, filesIn(name, '(?:import|load)\\(').every(isHlsOr(later)));
  promise(`${name} is whole without its comments`, spawnSync(process.execPath, ['--check', join(folder, name)]).status === 0
    || !name.endsWith('.js'));
}
const policy = read('index.html').toString().match(/Content-Security-Policy" content="([^"]*)"/)?.[1];
promise('its policy has no unsafe source and no other host', policy.startsWith("default-src 'none'")
  && !/unsafe|https?:|\*/.test(policy));
const FROM_STRINGS = /innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function/;
const fromStrings = names.filter(name => name.endsWith('.js') && !isHls(name) && FROM_STRINGS.test(read(name)));
promise('no module makes elements or code of strings', fromStrings.length === 0 || console.log(fromStrings));
promise('no page has a style or a script of its own lines', ['index.html', 'single.html'].every(name =>
  !/ style=| on\w+=|<style|<script(?! [^>]*src=)/.test(read(name))));
promise('what is copied has its licence', !names.includes('player/hls.worker.js')
  || /Apache License/.test(read('player/hls.LICENSE.txt').toString()));
