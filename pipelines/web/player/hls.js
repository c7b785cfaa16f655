// SPDX-License-Identifier: MIT
// The player for playlists that need hls.js, which the embedder's package manager has: a peer of this package.
import Hls from 'hls.js/light';
import { useHls } from './player.js';

export * from './player.js';

useHls(Hls);
