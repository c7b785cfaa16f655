// SPDX-License-Identifier: MIT
// What can go wrong, by its code, and the sentence for the viewer. A page may have sentences of its own, in `texts`.

const TEXTS = {
  'no-address': 'The name of the film or of its track is no address. Give the name of a file beside this page.',
  'from-disk': 'This page needs a web server. Run npx serve in its folder and open http://localhost:3000.',
  'protocol-refused':
    'An address that begins with {protocol} was refused. This page plays films over http and https only.',
  'origin-refused': 'A film of another server, {host}, was refused. This page plays films of its own server only.',
  'no-media':
    'A part of the film has neither picture nor sound. Is it a track alone? Play the film that it belongs to.',
  'part-damaged': 'A part of the film is damaged; it is left out.',
  'part-large': 'A part of the film is too large for this browser; it is left out. Package it with shorter segments.',
  'part-missing': 'A part of the film cannot be loaded{status}. Check the server.',
  'playlist-missing': 'The playlist cannot be loaded{status}. Check its name and the server.',
  'playlist-damaged': 'The playlist is damaged: it is no HLS playlist.',
  'codec': 'This browser cannot play the film’s codec. H.264 with AAC plays everywhere.',
  'cannot-play': 'The film cannot be played ({details}).',
  'no-media-source': 'This browser has no Media Source Extensions: the film plays, but it cannot be felt.',
  'needs-hls': 'This film needs hls.js, which this page does not have.',
  'track-damaged': 'Some packets of the haptic track are damaged; they are not felt.',
  'track-missing': 'The haptic track cannot be loaded{status}. Check its name and the server.',
  'track-large': 'The haptic track is larger than 8 MB. Package the film without --single.',
  'no-track': 'This film has no haptic track: nothing is felt.',
  'touch-missing': 'What can be touched cannot be loaded. Check the server.',
};

/** @returns the sentence for `code`: that of `texts` if it has one */
export function sentenceFor({ code, values }, texts) {
  const text = texts?.[code] ?? TEXTS[code] ?? code;
  return text.replace(/\{(\w+)\}/g, (_, name) => values[name] ?? '');
}

export class Problem extends Error {
  constructor(code, values = {}) {
    super(sentenceFor({ code, values }));
    Object.assign(this, { code, values });
  }
}

/** An address that the player does not ask. */
export class Refusal extends Problem {}
