// SPDX-License-Identifier: LGPL-2.1-or-later
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
  /** Address of an HLS playlist of this origin. Without it, call addPacket() yourself. */
  playlist?: string;
  /** Called for each frame of the screen while the film plays under a hand, and once with zero when a force ends. */
  onForce?(force: Force): void;
  /** Called once for each film that can be touched, with its first relief. */
  onRelief?(): void;
  /** Called once with each sentence for the viewer. */
  onProblem?(sentence: string): void;
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

export interface Player {
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
  readonly hasTrack: boolean;
  /** Names of the gamepads that can rumble. */
  readonly gamepads: string[];
  /** Plays a playlist instead of the one before. Fails with a Refusal if it is of another origin. */
  load(playlist: string): Promise<void>;
  /** KLV sets of the frame at `time`, s. */
  addPacket(bytes: Uint8Array, time: number): void;
  /** Zero, and lets go of the video. */
  detach(): void;
}

export class Refusal extends Error {}

/** Lets a hand feel the film in `video`. */
export function attach(video: HTMLVideoElement, options?: Options): Player;
