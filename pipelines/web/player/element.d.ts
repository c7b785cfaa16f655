// SPDX-License-Identifier: MIT
import type { AddPlayerListener, Held, Player } from './player.js';

export * from './player.js';

/** What a person holds of the film of a player (docs/web.md, "Hold"). The element has one; a page of your own makes one. */
export class Hold {
  constructor(player: Player, video: HTMLVideoElement, signal?: AbortSignal);
  /** Takes what is at the place of the player. */
  press(): void;
  release(): void;
  /** In the frame that is shown; null: nothing is held. */
  readonly held: Held | null;
  /** Draws it over the picture, in px of the canvas. Returns the place that a drawn hand may ride on. */
  draw(context: CanvasRenderingContext2D, picture: { x: number; y: number; width: number; height: number }): Held | null;
}
/**
 * Lets the mouse, a finger that rests and H hold, and the first button of a gamepad if the function that is returned is
 * called with each frame. Keys are those that come to `keys`.
 */
export function watchHolding(stage: HTMLElement, hold: Hold, keys: EventTarget, signal?: AbortSignal): () => void;

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
  addEventListener: AddPlayerListener & HTMLElement['addEventListener'];
}
declare global {
  interface HTMLElementTagNameMap { 'feeling-wind': FeelingWind }
}
