// SPDX-License-Identifier: MIT
// Plays a film in a video element and hands the packets of its track on. Nothing is fetched from another origin than
// those that the page allows, whatever a playlist names.

import { Problem, Refusal } from './problems.js';

const KLV_SCHEME = 'urn:misb:KLV:bin:1910.1';
const BACK_BUFFER = 60; // s; hls.js fetches what is older again when it is needed
const MOST_BYTES = 8 * 2 ** 20; // of a track beside the film
const LONGEST_SKIP = 8; // s, past damage: more than a group of frames lasts

/** @returns the address of a file of this origin or one of `origins`; else throws a Refusal */
export function addressOf(name, origins = [], base = document.baseURI) {
  let url;
  try {
    url = new URL(name, base);
  } catch {
    throw new Refusal('no-address');
  }
  requireOrigin(url, origins);
  return url.href;
}

function requireOrigin(url, origins) {
  if (url.protocol === 'file:') throw new Refusal('from-disk');
  if (!/^https?:$/.test(url.protocol)) throw new Refusal('protocol-refused', { protocol: url.protocol });
  if (url.origin !== location.origin && !origins.includes(url.origin))
    throw new Refusal('origin-refused', { host: url.host });
}

const statusOf = code => code ? ` (${code})` : '';

// An error of hls.js as a problem. Others mend themselves.
function problemOf({ fatal, details, response, reason }) {
  const status = statusOf(response?.code);
  if (details === 'fragParsingError')
    return new Problem(reason?.startsWith('Found no media') ? 'no-media' : 'part-damaged');
  if (details === 'manifestLoadError') return new Problem('playlist-missing', { status });
  if (details === 'manifestParsingError') return new Problem('playlist-damaged');
  if (/^(manifestIncompatibleCodecs|bufferAddCodec|bufferIncompatibleCodecs)Error$/.test(details))
    return new Problem('codec');
  if (!fatal) return null;
  if (details?.startsWith('frag')) return new Problem('part-missing', { status });
  return new Problem('cannot-play', { details });
}

/**
 * Plays the playlist `address` in `video` until `signal` is aborted. `hls` is the class of hls.js or an instance of it,
 * `hlsConfig` is for the class; without `hls` plain playlists play. Calls `onPacket(bytes, time)` for each packet of
 * the track, and `onProblem(problem)`. `onDamage(goOn)` gives what goes on after an error of the decoder, if it can.
 * @returns false if the track cannot be read here
 */
export async function playFilm(video, address, options) {
  const { hls, origins, signal, onProblem } = options;
  if (hls) return playWithHls(video, address, options);
  const { playPlainly } = await import('./plain-hls.js').catch(({ message: details }) => {
    throw new Problem('cannot-play', { details });
  });
  if (await playPlainly(video, address, { ...options, load: url => load(url, { origins, signal }) })) return;
  if (signal.aborted) return;
  onProblem(new Problem('needs-hls'));
  return playNatively(video, address, signal);
}

function playWithHls(video, address, { hls, hlsConfig, origins, signal, onPacket, onProblem, onDamage }) {
  const isClass = typeof hls === 'function';
  const Hls = isClass ? hls : hls.constructor;
  if (!Hls.isSupported()) {
    onProblem(new Problem('no-media-source'));
    return playNatively(video, address, signal);
  }
  const player = isClass ? new Hls({ backBufferLength: BACK_BUFFER, ...hlsConfig }) : hls;
  const { xhrSetup } = player.config;
  player.config.enableEmsgKLVMetadata = true;
  player.config.xhrSetup = (xhr, url) => {
    try {
      requireOrigin(new URL(url, address), origins);
    } catch (refusal) {
      onProblem(refusal);
      throw refusal;
    }
    return xhrSetup?.(xhr, url);
  };
  const onMetadata = (_, data) => {
    for (const sample of data.samples)
      if (String(sample.type ?? KLV_SCHEME).startsWith(KLV_SCHEME)) onPacket(sample.data, sample.pts);
  };
  let recoveries = 0, isCutOff = false;
  const onError = (_, error) => {
    const problem = problemOf(error);
    if (problem) onProblem(problem);
    if (!error.fatal) return;
    if (error.type === Hls.ErrorTypes.NETWORK_ERROR) isCutOff = true; // it has given up
    if (error.type === Hls.ErrorTypes.MEDIA_ERROR && recoveries++ < 3) player.recoverMediaError();
  };
  const onBuffered = () => { recoveries = 0; };
  const again = () => {
    if (isCutOff) player.startLoad(video.currentTime);
    isCutOff = false;
  };
  video.addEventListener('seeking', again, { signal });
  window.addEventListener('online', again, { signal });
  player.on(Hls.Events.FRAG_PARSING_METADATA, onMetadata);
  player.on(Hls.Events.ERROR, onError);
  player.on(Hls.Events.FRAG_BUFFERED, onBuffered);
  player.loadSource(address);
  player.attachMedia(video);
  onDamage?.(goOnWith(player, video, signal));
  signal.addEventListener('abort', () => {
    if (isClass) return player.destroy();
    player.off(Hls.Events.FRAG_PARSING_METADATA, onMetadata);
    player.off(Hls.Events.ERROR, onError);
    player.off(Hls.Events.FRAG_BUFFERED, onBuffered);
    player.config.xhrSetup = xhrSetup;
    player.detachMedia();
  });
}

// Past damage that a decoder gives up at: 1 s, and more as long as that is in the same group of frames.
function goOnWith(player, video, signal) {
  let skip = 0, end = -Infinity, plays = false;
  video.addEventListener('playing', () => { plays = true; }, { signal });
  video.addEventListener('pause', () => { if (!video.error) plays = false; }, { signal });
  return () => {
    const time = video.currentTime, wasPlaying = plays;
    skip = time > end + LONGEST_SKIP ? 1 : 2 * skip;
    if (skip > LONGEST_SKIP) return false;
    end = time + skip;
    player.detachMedia();
    player.attachMedia(video);
    player.startLoad(end);
    if (wasPlaying) video.play().catch(() => {});
    return true;
  };
}

function playNatively(video, address, signal) {
  if (video.canPlayType('application/vnd.apple.mpegurl')) playFile(video, address, signal);
  return false;
}

/** Ends what a video plays with `signal`, unless it plays something else by then. */
export function letGoWith(signal, video) {
  const { src } = video;
  signal.addEventListener('abort', () => {
    if (video.src !== src) return;
    video.removeAttribute('src');
    video.load();
  });
}

/** Plays a file that the browser plays by itself until `signal` is aborted. */
export function playFile(video, address, signal) {
  video.src = address;
  letGoWith(signal, video);
}

/** @returns the bytes of a file. Tries again where a network or a server may mend itself. */
export async function load(url, { origins = [], signal, most = Infinity, missing = 'part-missing' } = {}) {
  requireOrigin(new URL(url), origins);
  // Where other origins may be asked, a server could lead on to any.
  const [mode, redirect] = origins.length ? ['cors', 'error'] : ['same-origin', 'follow'];
  let status = '';
  for (const pause of [500, 1000, 2000, 4000, 0]) { // ms
    const answer = await fetch(url, { mode, redirect, signal }).catch(() => null);
    if (signal?.aborted) break;
    const bytes = answer?.ok && await bytesOf(answer, most);
    if (bytes) return bytes;
    status = statusOf(answer && !answer.ok && answer.status);
    if (status && answer.status < 500) break;
    await new Promise(done => setTimeout(done, pause));
  }
  throw new Problem(missing, { status });
}

// Null if the connection ends early; a Problem if there are more than `most`.
async function bytesOf(answer, most) {
  if (Number(answer.headers?.get('content-length')) > most) throw new Problem('track-large');
  const buffer = await answer.arrayBuffer().catch(() => null);
  if (buffer?.byteLength > most) throw new Problem('track-large');
  return buffer && new Uint8Array(buffer);
}

/** @returns the bytes of a track that is a file beside the film */
export const loadTrack = (url, options) => load(url, { ...options, most: MOST_BYTES, missing: 'track-missing' });

/** Packets of the film before this time (s) may be forgotten. */
export const forgottenBefore = time => time - 2 * BACK_BUFFER;
