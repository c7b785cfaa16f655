// SPDX-License-Identifier: LGPL-2.1-or-later
// What others write with the player's types (pipelines/web/player/player.d.ts). Compiled, not run.
import { attach, Refusal, type Field, type Force, type Options, type Place, type Player, type Relief } from '../../pipelines/web/player/player.js';
import { Hold, watchHolding, type FeelingWind } from '../../pipelines/web/player/element.js';

// As much of a browser as is needed: all of it takes seconds to compile.
declare global {
  interface HTMLVideoElement { readonly currentTime: number }
  interface AddEventListenerOptions { once?: boolean; signal?: AbortSignal }
  interface Event { readonly type: string }
  interface EventTarget { addEventListener(type: string, listener: (event: Event) => void, options?: AddEventListenerOptions): void }
  interface HTMLElementTagNameMap { video: HTMLVideoElement }
  class HTMLElement extends EventTarget {}
  class EventTarget {}
  interface CanvasRenderingContext2D { readonly canvas: unknown }
  interface AbortSignal { readonly aborted: boolean }
}
declare const film: HTMLVideoElement;
declare const console: { log(...values: unknown[]): void };

const options: Options = {
  playlist: 'film.m3u8', hls: null, hlsConfig: {}, allowedOrigins: ['https://films.example'], strength: 0.5,
  alpha: 0.04, rumble: false,
  onForce: ({ x, y, newtons, strongMagnitude, weakMagnitude, time }: Force) =>
    console.log(x + y + newtons + strongMagnitude + weakMagnitude + time),
  onRelief: () => console.log(player.hasTrack),
  onProblem: (sentence, code) => console.log(sentence.toUpperCase(), code),
  texts: { 'no-track': 'Nothing to feel.' },
};
const player: Player = attach(film, options);
const place: Place = { x: 0.5, y: 0.5 };
player.place = place;
player.place = null;
[player.strength, player.alpha] = [1, 0.01];
player.addPacket(new Uint8Array(3), player.force.x + player.force.y);
player.addEventListener('force', ({ detail }) => console.log(detail.newtons));
player.addEventListener('problem', ({ detail, code }) => console.log(detail.toUpperCase(), code), { once: true });
player.addEventListener('hold', ({ detail }) => console.log(detail?.state));
player.addEventListener('another', ({ type }) => console.log(type));
player.addPacket(new Uint8Array(3));
player.loadTrack('film.klv');
player.load('film.m3u8').catch((error: unknown) => console.log(error instanceof Refusal && error.code));
const field: Field | null = player.field;
console.log(field?.x.length, field && field.columns * field.rows + field.width + field.height + field.confidence.length);
player.pressed = true;
const relief: Relief | null = player.relief;
console.log(relief && [relief.z, relief.stiffness, relief.friction, relief.validity].length * relief.columns * relief.rows);
console.log(player.contact && player.contact.x + player.contact.y + player.contact.newtons);
console.log(player.hasTrack, player.hasReliefs, player.gamepads.join());
player.detach();
declare const element: FeelingWind;
const hold = new Hold(player, film);
hold.press();
console.log(hold.held?.state === 'about' && hold.held.x + hold.held.y + hold.held.radius + hold.held.time);
hold.release();
console.log(player.hold === hold, player.hold?.held?.id);
watchHolding(element, hold, element)();
element.allowedOrigins = ['https://films.example'];
console.log(element.player?.force.x, element.video?.currentTime);
element.addEventListener('force', ({ detail }) => console.log(detail.newtons));

// @ts-expect-error: it is read only
player.force = { x: 1, y: 1 };
// @ts-expect-error: so is this
player.hold = hold;
// @ts-expect-error: a force has no such number
player.addEventListener('force', ({ detail }) => console.log(detail.strength));
// @ts-expect-error: y is missing
player.place = { x: 1 };
// @ts-expect-error: there is no such option
attach(film, { stength: 1 });
