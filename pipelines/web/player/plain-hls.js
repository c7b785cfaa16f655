// SPDX-License-Identifier: MIT
// Plays a plain playlist of CMAF by Media Source Extensions alone, where hls.js is not beside the page: one rendition,
// VOD, segments as whole files, not encrypted, as `haptic-track package` writes them.

import { letGoWith } from './film.js';
import { Problem } from './problems.js';

const AHEAD = 20; // s to be buffered
const BEHIND = 60; // s to be kept
const KLV_SCHEME = 'urn:misb:KLV:bin:1910.1';

const NOT_PLAIN = /^#EXT-X-(KEY|BYTERANGE|DISCONTINUITY|MEDIA:.*URI=)|^#EXT-X-MAP[^]*^#EXT-X-MAP/m;

/** @returns {variant} or {map, segments: [{url, start: s, duration: s}], from: s, where the film begins}, or null */
export function readPlaylist(text, address) {
  if (!text.startsWith('#EXTM3U') || NOT_PLAIN.test(text)) return null;
  const lines = text.split(/\r?\n/);
  const urlOf = name => new URL(name, address).href;
  const variant = lines.findIndex(line => line.startsWith('#EXT-X-STREAM-INF'));
  if (variant >= 0) return lines[variant + 1] ? { variant: urlOf(lines[variant + 1]) } : null;
  const map = text.match(/^#EXT-X-MAP:URI="([^"]+)"\s*$/m)?.[1];
  const segments = [];
  let start = 0, duration = 0;
  for (const line of lines) {
    if (line.startsWith('#EXTINF:')) duration = parseFloat(line.slice(8));
    if (!line || line.startsWith('#')) continue;
    if (!(duration > 0)) return null;
    segments.push({ url: urlOf(line), start, duration });
    start += duration;
  }
  const isWhole = /^#EXT-X-ENDLIST/m.test(text), from = Number(text.match(/^#EXT-X-START:.*TIME-OFFSET=([\d.]+)/m)?.[1] ?? 0);
  return map && segments.length && isWhole ? { map: urlOf(map), segments, from } : null;
}

// Yields the boxes at the top of a file.
function* boxes(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  for (let at = 0; at + 8 <= bytes.length;) {
    const size = view.getUint32(at) || bytes.length - at;
    if (size < 8 || size > bytes.length - at) return;
    yield { type: String.fromCharCode(...bytes.subarray(at + 4, at + 8)), content: bytes.subarray(at + 8, at + size) };
    at += size;
  }
}

/** Yields {time: s, bytes} of each packet of the track in a segment that begins at `start` (ISO/IEC 23009-1, 5.10.3.3). */
export function* readPackets(segment, start) {
  for (const { type, content } of boxes(segment)) {
    if (type !== 'emsg' || content.length < 24) continue;
    const view = new DataView(content.buffer, content.byteOffset, content.length);
    const isNew = content[0] === 1;
    let at = isNew ? 24 : 4;
    const text = () => {
      const end = content.indexOf(0, at);
      const string = end < 0 ? '' : String.fromCharCode(...content.subarray(at, Math.min(end, at + 200)));
      at = end < 0 ? content.length : end + 1;
      return string;
    };
    const scheme = text();
    text();
    if (!scheme.startsWith(KLV_SCHEME) || (!isNew && at + 16 > content.length)) continue;
    const scale = view.getUint32(isNew ? 4 : at);
    const time = isNew ? Number(view.getBigUint64(8)) / scale : start + view.getUint32(at + 4) / scale;
    yield { time, bytes: content.subarray(isNew ? at : at + 16) };
  }
}

/** @returns the type of media of an initialization segment, or null without H.264 */
export function mediaType(header) {
  const text = new TextDecoder('latin1').decode(header);
  const at = text.indexOf('avcC');
  if (at < 0 || at + 8 > header.length) return null;
  const avc = Array.from(header.subarray(at + 5, at + 8), byte => byte.toString(16).padStart(2, '0')).join('');
  return `video/mp4; codecs="avc1.${avc}${text.includes('mp4a') ? ', mp4a.40.2' : ''}"`;
}

// What is wanted next changes with the time of the film, and with the network.
function changeOf(video) {
  const changed = new AbortController();
  return new Promise(done => {
    const end = () => {
      changed.abort();
      done();
    };
    for (const event of ['timeupdate', 'seeking', 'emptied'])
      video.addEventListener(event, end, { signal: changed.signal });
    window.addEventListener('online', end, { signal: changed.signal });
  });
}

class PlainFilm {
  #video;
  #options;
  #list;
  #buffer;
  #last = null; // segment that was appended; not fetched again and again if it fills no gap

  constructor(video, list, options) {
    [this.#video, this.#list, this.#options] = [video, list, options];
    const again = () => { this.#last = null; };
    video.addEventListener('seeking', again, { signal: options.signal });
    window.addEventListener('online', again, { signal: options.signal });
  }

  async begin() {
    const { load, signal, onProblem } = this.#options;
    const header = await load(this.#list.map);
    const type = mediaType(header);
    if (!type || !MediaSource.isTypeSupported(type)) throw new Problem('codec');
    if (signal.aborted) return;
    const source = new MediaSource();
    const opened = new Promise(done => source.addEventListener('sourceopen', done, { once: true }));
    const url = this.#video.src = URL.createObjectURL(source);
    letGoWith(signal, this.#video);
    await opened;
    URL.revokeObjectURL(url);
    if (signal.aborted) return;
    const last = this.#list.segments.at(-1);
    source.duration = last.start + last.duration;
    this.#buffer = source.addSourceBuffer(type);
    await this.#change(() => this.#buffer.appendBuffer(header));
    if (this.#list.from > 0 && this.#video.currentTime === 0) this.#video.currentTime = this.#list.from;
    while (!signal.aborted) {
      const segment = this.#wanted();
      if (segment && segment !== this.#last) // after a failure a seek or the network goes on
        await this.#append(segment, source, segment === last).catch(onProblem);
      else if (segment === undefined && source.readyState === 'open') source.endOfStream(); // after a seek back, too
      else await changeOf(this.#video);
    }
  }

  // The segment that follows what is buffered at the present time: null if there is enough, undefined at the end. Where a
  // seek led to, it is the one of that time; later, frames may begin or end a little beside what the playlist says.
  #wanted() {
    const { buffered } = this.#buffer, now = this.#video.currentTime;
    const { segments } = this.#list, last = segments.at(-1);
    let time = now, isHere = false;
    for (let i = 0; i < buffered.length; ++i) {
      isHere ||= buffered.start(i) <= now && buffered.end(i) > now;
      if (buffered.start(i) <= time + 0.2 && buffered.end(i) > time) time = buffered.end(i);
    }
    const here = segments.find(({ start, duration }) => start + duration > now);
    if (!isHere && here && !this.#last) return here;
    if (time - now > AHEAD) return null;
    const isLastThere = buffered.length > 0 && buffered.end(buffered.length - 1) > last.start;
    return segments.find(({ start, duration }) => start + duration > time + 0.15) ?? (isLastThere ? undefined : last);
  }

  async #append(segment, source, isLast) {
    this.#last = segment;
    const { load, signal, onPacket } = this.#options;
    const bytes = await load(segment.url);
    if (signal.aborted) return;
    for (const { time, bytes: packet } of readPackets(bytes, segment.start)) onPacket(packet, time);
    const old = this.#video.currentTime - BEHIND;
    if (old > 0) await this.#change(() => this.#buffer.remove(0, old));
    while (!await this.#fits(bytes) && !signal.aborted) await this.#makeRoom();
    if (isLast && source.readyState === 'open') source.endOfStream();
  }

  // Appends it, unless the buffer is full.
  #fits(bytes) {
    return this.#change(() => this.#buffer.appendBuffer(bytes)).then(() => true, error => {
      if (error.name !== 'QuotaExceededError') throw error;
      return false;
    });
  }

  // What is before the present segment goes. A browser removes whole groups of frames, and a segment begins with one.
  async #makeRoom() {
    const { buffered } = this.#buffer, { currentTime } = this.#video;
    const { start } = this.#list.segments.findLast(segment => segment.start <= currentTime);
    if (buffered.length && buffered.start(0) < start) return this.#change(() => this.#buffer.remove(0, start));
    const isPlayedOut = !buffered.length || buffered.end(buffered.length - 1) <= currentTime + 0.2;
    if (isPlayedOut) throw new Problem('part-large');
    await changeOf(this.#video);
  }

  #change(begin) {
    return new Promise((done, fail) => {
      this.#buffer.onupdateend = done;
      this.#buffer.onerror = () => fail(new Problem('part-damaged'));
      begin();
    });
  }
}

/**
 * `load(url)` gives the bytes of a file, or fails; the other options are those of playFilm().
 * @returns whether the playlist is plain enough
 */
export async function playPlainly(video, address, options) {
  const read = async url => readPlaylist(new TextDecoder().decode(await options.load(url)), url);
  let list = await read(address);
  if (list?.variant) list = await read(list.variant);
  if (!list?.map || !globalThis.MediaSource) return false;
  if (!options.signal.aborted) new PlainFilm(video, list, options).begin().catch(options.onProblem);
  return true;
}
