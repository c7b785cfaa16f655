// SPDX-License-Identifier: LGPL-2.1-or-later
// What a test of the page prints.

/** Ends the test unless the promise is kept. */
export function promise(text, kept) {
  console.log(`${kept ? 'ok' : 'NOT OK'}: ${text}`);
  if (!kept) process.exit(1);
}

export function skip(reason) {
  console.log(`SKIPPED: ${reason}`);
  process.exit(77);
}
