// SPDX-License-Identifier: LGPL-2.1-or-later
// Plays a playlist with hls.js in a video element and hands the track's packets on. Nothing is fetched from another
// origin, whatever a playlist names.

import { letGo, playPlainly } from './plain-hls.js';

const KLV_SCHEME = 'urn:misb:KLV:bin:1910.1';
const BACK_BUFFER = 60; // s; hls.js fetches what is older again when it is needed

export class Refusal extends Error {}

/** @returns the address of a playlist of this origin; else throws a Refusal for people */
export function playlistAddress(name, base = document.baseURI) {
  let url;
  try {
    url = new URL(name, base);
  } catch {
    throw new Refusal('The name of the playlist is no address. Give the name of an .m3u8 file beside this page.');
  }
  requireSameOrigin(url);
  return url.href;
}

function requireSameOrigin(url) {
  if (!/^https?:$/.test(url.protocol))
    throw new Refusal(`An address that begins with ${url.protocol} was refused. `
      + 'This page plays films over http and https only.');
  if (url.origin !== location.origin)
    throw new Refusal(`A film of another server, ${url.host}, was refused. `
      + 'This page plays films of its own server only.');
}

// An error of hls.js as a sentence. Others mend themselves.
function sentenceFor({ fatal, details, response, reason }) {
  const code = response?.code ? ` (${response.code})` : '';
  if (details === 'fragParsingError' && reason?.startsWith('Found no media'))
    return 'A part of the film has neither picture nor sound. Is it a track alone? Play the film that it belongs to.';
  if (details === 'fragParsingError') return 'A part of the film is damaged; it is left out.';
  if (details === 'manifestLoadError') return `The playlist cannot be loaded${code}. Check its name and the server.`;
  if (details === 'manifestParsingError') return 'The playlist is damaged: it is no HLS playlist.';
  if (/^(manifestIncompatibleCodecs|bufferAddCodec|bufferIncompatibleCodecs)Error$/.test(details))
    return 'This browser cannot play the film’s codec. H.264 with AAC plays everywhere.';
  if (!fatal) return null;
  return details?.startsWith('frag') ? `A part of the film cannot be loaded${code}. Check the server.`
    : `The film cannot be played (${details}).`;
}

/**
 * Loads `address` into `video`. Calls `onPacket(bytes, time)` for each packet of the track and `onProblem(sentence)`.
 * @returns a function that lets go of the video
 */
export async function playFilm(video, address, { onPacket, onProblem }) {
  let Hls;
  try {
    ({ default: Hls } = await import('./hls.light.min.js'));
  } catch {
    return playWithoutHls(video, address, { onPacket, onProblem });
  }
  if (!Hls.isSupported()) {
    onProblem('This browser has no Media Source Extensions: the film plays, but it cannot be felt.');
    return playNatively(video, address);
  }
  const hls = new Hls({
    enableEmsgKLVMetadata: true,
    workerPath: new URL('hls.worker.js', import.meta.url).href,
    backBufferLength: BACK_BUFFER,
    xhrSetup(xhr, url) {
      try {
        requireSameOrigin(new URL(url, address));
      } catch (refusal) {
        onProblem(refusal.message);
        throw refusal;
      }
    },
  });
  hls.on(Hls.Events.FRAG_PARSING_METADATA, (_, data) => {
    for (const sample of data.samples)
      if (String(sample.type ?? KLV_SCHEME).startsWith(KLV_SCHEME)) onPacket(sample.data, sample.pts);
  });
  let recoveries = 0;
  hls.on(Hls.Events.ERROR, (_, error) => {
    const sentence = sentenceFor(error);
    if (sentence) onProblem(sentence);
    if (error.fatal && error.type === Hls.ErrorTypes.MEDIA_ERROR && recoveries++ < 3) hls.recoverMediaError();
  });
  hls.loadSource(address);
  hls.attachMedia(video);
  return () => hls.destroy();
}

/** @returns the bytes of a file. Tries again where a network or a server may mend itself. */
export async function load(url) {
  requireSameOrigin(new URL(url));
  let code = '';
  for (const pause of [500, 1000, 2000, 4000, 0]) { // ms
    const answer = await fetch(url, { mode: 'same-origin' }).catch(() => null);
    const bytes = answer?.ok && await answer.arrayBuffer().catch(() => null);
    if (bytes) return new Uint8Array(bytes);
    code = answer && !answer.ok ? ` (${answer.status})` : '';
    if (code && answer.status < 500) break;
    await new Promise(done => setTimeout(done, pause));
  }
  throw new Error(`A part of the film cannot be loaded${code}. Check the server.`);
}

async function playWithoutHls(video, address, { onPacket, onProblem }) {
  const film = await playPlainly(video, address, load, onPacket, onProblem);
  if (film) return () => film.end();
  onProblem('This film needs hls.js: build the page again after pipelines/web/fetch.sh.');
  return playNatively(video, address);
}

function playNatively(video, address) {
  if (video.canPlayType('application/vnd.apple.mpegurl')) video.src = address;
  return () => letGo(video);
}

/** Packets of the film before this time (s) may be forgotten. */
export const forgottenBefore = time => time - 2 * BACK_BUFFER;
