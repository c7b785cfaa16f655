// SPDX-License-Identifier: MIT
import type { Hold } from './element.js';

/** A place in the picture, from its top left corner; z is the size of the hand, 1 near and -1 far. */
export interface Place { x: number; y: number; z?: number }

export interface Force {
  /** N, to the right, as hapticsink commands it. */
  x: number;
  /** N, up. */
  y: number;
  newtons: number;
  /** What is asked of a gamepad, 0..1. */
  strongMagnitude: number;
  weakMagnitude: number;
  /** s, of the film. */
  time: number;
}

export interface Options {
  /** Address of an HLS playlist with a track. The player plays it in the video. */
  playlist?: string;
  /** Address of a track, a file of KLV beside a film that the video plays by itself. */
  track?: string;
  /** The class of hls.js, or an instance of yours. Without it, plain playlists of CMAF play. */
  hls?: unknown;
  /** For the class of hls.js. */
  hlsConfig?: object;
  /** Origins beside that of the page from which films and tracks may come. */
  allowedOrigins?: string[];
  /** Ends the player when it is aborted, as detach() does. */
  signal?: AbortSignal;
  /** Sentences of your own, by the code of the problem; {host}, {status} and so on are filled in. */
  texts?: Record<string, string>;
  /** Called for each frame of the screen while the film plays under a hand, and once with zero when a force ends. */
  onForce?(force: Force): void;
  /** Called once for each film that can be touched, with its first relief. */
  onRelief?(): void;
  /** Called once with each sentence for the viewer, and its code. */
  onProblem?(sentence: string, code: string): void;
  /** Share of the gamepad's strength, 0..1; default 1. */
  strength?: number;
  /** Steepness of the force law in s/px; default 0.01. */
  alpha?: number;
  /** False: no gamepad and no phone vibrates. */
  rumble?: boolean;
}

/** A field of velocities in px/s of a frame `width` px wide, y down; row by row. */
export interface Field {
  columns: number; rows: number; width: number; height: number;
  x: Float32Array; y: Float32Array; confidence: Float32Array;
}

/** A surface: numbers of each cell, row by row. */
export interface Relief {
  columns: number; rows: number; width: number; height: number;
  /** m, towards the viewer; the picture is 0.05 m wide and high. */
  z: Float32Array;
  /** N/m. */
  stiffness: Float32Array;
  friction: Float32Array;
  /** 0: there is no surface. */
  validity: Float32Array;
}

/** A thing that is held, or the place that is. */
export interface Held {
  state: 'held' | 'about' | 'hidden' | 'lost';
  /** 0..1 from the top left corner; where it was last, if it is lost. */
  x: number; y: number;
  /** Share of the width of the picture. */
  radius: number;
  /** Of the thing in the track; null: a place is held. */
  id: number | null;
  /** s of the film since the press. */
  time: number;
}

/**
 * `detail` is what the callback gets, `code` that of a problem. Of hold it is what is held, or null, when its state changes
 * or another press takes something.
 */
export interface PlayerEvents {
  force: Event & { readonly detail: Force };
  relief: Event;
  problem: Event & { readonly detail: string; readonly code: string };
  hold: Event & { readonly detail: Held | null };
}
export type AddPlayerListener = <Name extends keyof PlayerEvents>(
  type: Name, listener: (event: PlayerEvents[Name]) => void, options?: boolean | AddEventListenerOptions) => void;
export interface PlayerEventTarget extends EventTarget {
  addEventListener: AddPlayerListener & EventTarget['addEventListener'];
}

export interface Player extends PlayerEventTarget {
  /** Where the hand is; null: nowhere, and nothing is felt. */
  place: Place | null;
  /** Whether the hand presses on the surface; without it only motion is felt. */
  pressed: boolean;
  strength: number;
  alpha: number;
  readonly force: { x: number; y: number };
  /** The field of the frame that is shown. */
  readonly field: Field | null;
  /** The relief of the frame that is shown. */
  readonly relief: Relief | null;
  /** Where the surface is touched, 0..1 from the top left corner, and the force out of the picture. */
  readonly contact: { x: number; y: number; newtons: number } | null;
  /** Whether the film can be touched, maybe later. */
  readonly hasReliefs: boolean;
  readonly hasTrack: boolean;
  /** What was made for this player to hold with; null: nothing. */
  readonly hold: Hold | null;
  /** Names of the gamepads that can rumble. */
  readonly gamepads: string[];
  /** Plays a playlist instead of the film before. Fails with a Refusal if its address is refused. */
  load(playlist: string): Promise<void>;
  /** Feels another track beside the film that the video plays by itself; null: none. */
  loadTrack(track: string | null): Promise<void>;
  /** KLV sets of the frame at `time`, s; without it, each has its own time. */
  addPacket(bytes: Uint8Array, time?: number): void;
  /** Zero, and lets go of the video. */
  detach(): void;
}

export class Problem extends Error {
  code: string;
  values: Record<string, string>;
}
/** An address that the player does not ask. */
export class Refusal extends Problem {}

/** From now on, players without the option `hls` take this class of hls.js. */
export function useHls(hls: unknown): void;

/** Lets a hand feel the film in `video`. */
export function attach(video: HTMLVideoElement, options?: Options): Player;
