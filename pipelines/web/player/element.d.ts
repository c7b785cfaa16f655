// SPDX-License-Identifier: MIT
import type { Player } from './player.js';

export * from './player.js';

/**
 * The element <feeling-wind>, a film that is felt. Attributes: `src`, a video or an HLS playlist (.m3u8); `track`, a
 * file of KLV beside a video; `alpha`; `strength`. It uses a <video> in it, or makes one with controls. The properties
 * `hlsConfig`, `allowedOrigins` and `texts`, the options of attach(), are set before it comes into a page. It sends the
 * events of the player.
 */
export class FeelingWind extends HTMLElement {
  readonly player: Player | null;
  readonly video: HTMLVideoElement | null;
  hlsConfig?: object;
  allowedOrigins?: string[];
  texts?: Record<string, string>;
}
