// SPDX-License-Identifier: LGPL-2.1-or-later
// A static server on the loopback for the tests of the page. It knows nothing of films.
import { createReadStream, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';

const TYPES = {
  '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css', '.ts': 'video/mp2t',
  '.m3u8': 'application/vnd.apple.mpegurl', '.jpg': 'image/jpeg', '.mp4': 'video/mp4', '.m4s': 'video/iso.segment',
  '.svg': 'image/svg+xml',
};

/** Serves the files of `folders`, the first that has one, also a part of one. A name in `silent` gets no answer. */
export async function serve(folders, silent = new Set(), headers = {}) {
  const server = createServer((request, response) => {
    const name = normalize(decodeURIComponent(new URL(request.url, 'http://here').pathname));
    if (silent.has(name.slice(1))) return;
    const file = folders.map(folder => join(folder, name === '/' ? 'index.html' : name)).find(isFile);
    if (!file) return response.writeHead(404).end();
    const { size } = statSync(file);
    const [, from, to] = request.headers.range?.match(/^bytes=(\d+)-(\d*)$/) ?? [];
    const [start, end] = [Number(from ?? 0), Math.min(Number(to || size - 1), size - 1)];
    response.writeHead(from ? 206 : 200, {
      'content-type': TYPES[extname(file)] ?? 'application/octet-stream', 'content-length': end - start + 1,
      'accept-ranges': 'bytes', ...from && { 'content-range': `bytes ${start}-${end}/${size}` }, ...headers,
    });
    createReadStream(file, { start, end: Math.max(end, 0) }).pipe(response);
  });
  await new Promise(ready => server.listen(0, '127.0.0.1', ready));
  const close = () => {
    server.closeAllConnections();
    server.close();
  };
  return { origin: `http://127.0.0.1:${server.address().port}`, close };
}

function isFile(path) {
  return statSync(path, { throwIfNoEntry: false })?.isFile() ?? false;
}
