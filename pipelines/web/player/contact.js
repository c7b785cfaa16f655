// SPDX-License-Identifier: MIT
// The surface of a relief and the force of touching it, as gst-plugins/device/touch/relief-surface.cpp and contact-law.cpp
// (docs/force.md, "Touch"), for a finger that presses DEPTH deep. Without damper against the hand and rules of energy: they
// are about a hand that the force moves.
import { clamp } from './field-codec.js';

/** m, half extents of the workspace, which shows the whole picture: those of the default geometry */
export const HALF = 0.025;
/** m, at right angles to the surface: 0.5 N where it is stiffest */
export const DEPTH = 0.0025;
const STEEPEST = 0.25; // least z of the normal of a slope that the finger follows: 76°
const SURFACE = 0.5; // validity from which there is a surface
const STIFFEST = 200; // N/m
const MAX_FORCE = 1; // N
const SLEW = 0.02; // N in a tick
const SLIDE_STEPS = 8; // of half a cell, in a tick
const HALVINGS = 5;
const AT_REST = 1e-8; // m of slip that is not worth a step
const HANGING = 1e-4; // m outside the friction cone
const DAMPING = 5; // ticks: damper over spring, against the surface's own speed
const WHOLE = 5e-4; // m of depth from which the damper is whole
const CLIMB = 1e-4; // m in a tick, at which the surface comes back from the finger: 0.1 m/s

const dot = (a, b) => a.x * b.x + a.y * b.y + a.z * b.z;
const norm = v => Math.sqrt(dot(v, v));
const times = (v, by) => ({ x: by * v.x, y: by * v.y, z: by * v.z });
const plus = (a, b) => ({ x: a.x + b.x, y: a.y + b.y, z: a.z + b.z });
const minus = (a, b) => plus(a, times(b, -1));
const stiffnessOf = at => Math.min(at.stiffness, STIFFEST);
const shorten = (v, most) => norm(v) > most ? times(v, most / norm(v)) : v;

// The two cells between whose centres a place lies, and the weight of the second.
function between(place, cells) {
  const at = clamp(place * cells - 0.5, 0, cells - 1), first = Math.trunc(at);
  return [first, Math.min(first + 1, cells - 1), at - first];
}

// Adds the four cells around (u, v), parts of the picture.
function addRelief(relief, u, v, weight, sums) {
  const [left, right, across] = between(u, relief.columns), [top, bottom, down] = between(v, relief.rows);
  for (const [row, column, share] of [[top, left, (1 - down) * (1 - across)], [top, right, (1 - down) * across],
    [bottom, left, down * (1 - across)], [bottom, right, down * across]]) {
    const i = row * relief.columns + column;
    const valid = weight * share * relief.validity[i];
    sums.validity += valid;
    sums.z += valid * relief.z[i];
    sums.stiffness += valid * relief.stiffness[i];
    sums.friction += valid * relief.friction[i];
  }
}

/** A relief, or a line between two in time. Places in m of the workspace: x right, y up, z towards the user. */
export class Surface {
  #from;
  #to;
  #weight;
  #cell; // m, width and height
  /** `weight` 0..1, of `to` */
  constructor(from, to, weight) {
    [this.#from, this.#to, this.#weight] = [from, to, weight];
    this.#cell = [2 * HALF / Math.max(from.columns, to.columns), 2 * HALF / Math.max(from.rows, to.rows)];
  }

  /** m, the smaller side */
  get cell() { return Math.min(...this.#cell); }

  /** @returns {z, stiffness: N/m, friction}, or null where there is no surface */
  at(x, y) {
    const u = 0.5 + x / (2 * HALF), v = 0.5 - y / (2 * HALF);
    const sums = { validity: 0, z: 0, stiffness: 0, friction: 0 };
    if (this.#weight < 1) addRelief(this.#from, u, v, 1 - this.#weight, sums);
    if (this.#weight > 0) addRelief(this.#to, u, v, this.#weight, sums);
    const { validity } = sums;
    if (!(validity >= SURFACE) || sums.z > HALF * validity) return null;
    return { z: sums.z / validity, stiffness: sums.stiffness / validity, friction: sums.friction / validity };
  }

  #slope(x, y, dx, dy) {
    const here = this.at(x, y), before = this.at(x - dx, y - dy), after = this.at(x + dx, y + dy);
    const run = (dx + dy) * (Number(before !== null) + Number(after !== null));
    return run > 0 ? ((after ?? here).z - (before ?? here).z) / run : 0;
  }

  /** The unit normal where there is a surface: of the slope between half a cell to each side. */
  normal(x, y) {
    const [width, height] = this.#cell;
    const v = { x: -this.#slope(x, y, width / 2, 0), y: -this.#slope(x, y, 0, height / 2), z: 1 };
    return times(v, 1 / norm(v));
  }
}

/** A god-object proxy with Coulomb friction. One call of step() for each ms. */
export class Contact {
  /** m, where the finger touches; null: it does not */
  proxy = null;
  /** N, on the finger */
  force = { x: 0, y: 0, z: 0 };
  #lag = 0; // m, of the felt surface above the film's

  release() {
    this.proxy = null;
    this.force = { x: 0, y: 0, z: 0 };
  }

  /** The finger presses at (x, y), m. */
  step(surface, x, y) {
    const here = surface.at(x, y);
    if (!here) return this.release();
    const finger = { x, y, z: here.z - DEPTH / Math.max(surface.normal(x, y).z, STEEPEST) };
    const under = this.proxy && surface.at(this.proxy.x, this.proxy.y);
    if (!under) this.proxy = { x, y, z: here.z };
    const lag = under ? this.proxy.z - under.z : 0;
    this.#lag = lag - clamp(lag, -CLIMB, CLIMB);
    this.proxy.z = (under || here).z + this.#lag;
    const point = this.#slide(surface, finger, under || here);
    if (this.#hangs(surface, finger, point) || finger.z > here.z + this.#lag + AT_REST) this.proxy = finger;
    const spring = minus(this.proxy, finger), depth = norm(spring) || 1;
    const damper = 1 + DAMPING * Math.min(1 / WHOLE, 1 / depth) * Math.max(-clamp(lag, -CLIMB, CLIMB) * spring.z / depth, 0);
    const wanted = shorten(times(spring, damper * stiffnessOf(point)), MAX_FORCE);
    this.force = plus(this.force, shorten(minus(wanted, this.force), SLEW));
  }

  // Of a falling flank: beneath the finger, and outside the friction cone.
  #hangs(surface, finger, { friction }) {
    const spring = minus(this.proxy, finger), normal = surface.normal(this.proxy.x, this.proxy.y);
    const depth = Math.max(dot(spring, normal), 0);
    return spring.z < 0 && norm(minus(spring, times(normal, depth))) > friction * depth + HANGING;
  }

  // The proxy slips until the spring is within the friction cone, as far as that lowers the energy. Returns its place.
  #slide(surface, finger, point) {
    const energy = (at, place) => stiffnessOf(at) * norm(minus(place, finger)) ** 2;
    let now = energy(point, this.proxy);
    for (let i = 0; i < SLIDE_STEPS; ++i) {
      const normal = surface.normal(this.proxy.x, this.proxy.y);
      const spring = minus(this.proxy, finger);
      const depth = Math.max(dot(spring, normal), 0);
      const tangent = minus(spring, times(normal, depth)), length = norm(tangent);
      let step = Math.min(length - point.friction * depth, surface.cell / 2), slipped = false;
      for (let tried = 0; tried < HALVINGS && step > AT_REST && !slipped; ++tried, step /= 2) {
        const place = minus(this.proxy, times(tangent, step / length));
        const there = surface.at(place.x, place.y);
        if (!there) continue;
        place.z = there.z + this.#lag;
        const then = energy(there, place);
        if (then >= now) continue;
        [this.proxy, point, now, slipped] = [place, there, then, true];
      }
      if (!slipped) break;
    }
    return point;
  }
}
