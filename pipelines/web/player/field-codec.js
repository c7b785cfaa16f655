// SPDX-License-Identifier: MIT
// Decoder of motion fields (docs/formats/field-code.md), equal to gst-plugins/track/field-code/field-codec.cpp bit for bit.
// Velocities are single precision there, so each step is rounded with Math.fround. touch.js adds reliefs.

const KEY = 1, RESTED = 2, INTERVAL = 4, OF_PAIR = 8; // bits of the first byte; above them the field's flags
const FLAG_SHIFT = 4;
export const STILL = 1, CUT = 4; // flags of a field
export const MOST_CELLS = 8192;
const LONGEST_INTERVAL = 2 ** 53; // µs
const MOST_32 = 2 ** 32 - 1;
const FIRST_SEQUENCE = 1;

// ---- scale

export const fround = Math.fround;
const LARGEST_NUMBER = 160;
const EVEN_STEPS = 16;
// px per frame of each number: n / 4 up to 4, then 4 exp((n - 16) / 16).
const SPEEDS = Float32Array.from({ length: LARGEST_NUMBER + 1 }, (_, n) =>
  n <= EVEN_STEPS ? n / 4 : 4 * fround(Math.exp((n - EVEN_STEPS) / EVEN_STEPS)));
const LARGEST_CONFIDENCE = 4;

// Returns the microseconds as ns in single precision, rounded once.
function nanoseconds(us) {
  if (us * 1000 <= Number.MAX_SAFE_INTEGER) return fround(us * 1000);
  // The lowest of 40 bits is set if any below it is, so that rounding to double first changes nothing.
  const exact = BigInt(us) * 1000n;
  const shift = BigInt(exact.toString(2).length - 40);
  const top = exact >> shift;
  return fround(Number(top << shift === exact ? top : top | 1n)) * 2 ** Number(shift);
}

// Returns the px/s that are one px per frame.
function unitOf(us) {
  return fround(1 / (us > 0 ? fround(nanoseconds(us) * fround(1e-9)) : fround(1 / 30)));
}

// ---- range decoder (gst-plugins/track/field-code/range-coder.hpp)

// Places of the models in one array.
const NUMBER_SIZE = 14;
export const EVEN = 2048; // of 4096
const MOVED = 0, TURNED = 16, X = 20, Y = X + 4 * NUMBER_SIZE, CONFIDENCE = Y + 4 * NUMBER_SIZE;
const MODELS = CONFIDENCE + 2 * NUMBER_SIZE;
const LENGTHS = 10;
const FRESH = new Uint16Array(MODELS).fill(EVEN);
FRESH.set([4070, 3600, 3300, 2600, 3900, 3000, 2400, 1400, 3800, 3000, 2600, 1600, 3000, 2000, 1400, 500], MOVED);
FRESH.set([4050, 3000, 2000, 1000], TURNED);

const zeros = new Uint16Array(MODELS); // of 4096 bits of a kind
const seen = new Uint8Array(MODELS);
let bytes, at, range, code;

function begin(input, from, fresh) {
  zeros.set(fresh);
  seen.fill(0);
  bytes = input;
  at = from;
  range = 0xFFFFFFFF;
  code = 0;
  for (let i = 0; i < 4; ++i) code = (code << 8 | next()) >>> 0;
}

// Zeros follow behind the end.
function next() {
  return at < bytes.length ? bytes[at++] : 0;
}

function normalize() {
  while (range < 0x1000000) {
    range = range << 8 >>> 0;
    code = (code << 8 | next()) >>> 0;
  }
}

export function bit(model) {
  const p = zeros[model];
  const bound = (range >>> 12) * p;
  const rate = seen[model] < 6 ? 3 + (seen[model]++ >> 1) : 5;
  const one = code >= bound;
  if (one) {
    code -= bound;
    range -= bound;
    zeros[model] = p - (p >> rate);
  } else {
    range = bound;
    zeros[model] = p + (4095 - p >> rate);
  }
  if (range < 0x1000000) normalize();
  return one ? 1 : 0;
}

function evenBit() {
  range >>>= 1;
  const one = code >= range;
  if (one) code -= range;
  normalize();
  return one ? 1 : 0;
}

// The bits of a kind of number of `lengths` bits at most: zero, sign, lengths, 2 first bits.
export function number(model, lengths = LENGTHS) {
  if (bit(model)) return 0;
  const negative = bit(model + 1);
  let length = 0;
  while (length + 1 < lengths && bit(model + 2 + length)) ++length;
  let size = 1;
  for (let i = length; i-- > 0;)
    size = size << 1 | (i + 1 === length ? bit(model + 2 + lengths + (length > 1 ? 1 : 0)) : evenBit());
  return negative ? -size : size;
}

// ---- cells

export const sizeClass = (a, b) => {
  const sum = Math.abs(a) + Math.abs(b);
  return sum <= 1 ? sum : sum <= 4 ? 2 : 3;
};
export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const limited = n => clamp(n, -LARGEST_NUMBER, LARGEST_NUMBER);

// The changes of one row, with one more cell at each end.
class Row {
  constructor(cells) {
    this.moved = new Uint8Array(cells);
    this.turned = new Uint8Array(cells);
    this.x = new Int16Array(cells); // velocity minus what was expected
    this.y = new Int16Array(cells);
    this.confidence = new Int32Array(cells); // difference from what was held; it adds up
  }
  clear() {
    this.moved.fill(0);
    this.turned.fill(0);
    this.x.fill(0);
    this.y.fill(0);
    this.confidence.fill(0);
  }
}

// Mean of the neighbours that came before the cell and have a confidence, half away from zero.
function expected(values, confidence, i, column, columns) {
  let count = 0, sum = 0;
  const above = i - columns;
  if (column > 0 && confidence[i - 1]) ++count, sum += values[i - 1];
  if (above >= 0 && confidence[above]) ++count, sum += values[above];
  if (above >= 0 && column + 1 < columns && confidence[above + 1]) ++count, sum += values[above + 1];
  return count ? Math.trunc((2 * sum + (sum < 0 ? -count : count)) / (2 * count)) : 0;
}

// Applies the changes of the code to `cells`.
function decodeCells(cells, columns) {
  let above = new Row(columns + 2), row = new Row(columns + 2);
  const { x, y, confidence, changed } = cells;
  for (let i = 0, column = 0; i < x.length; ++i, ++column) {
    if (column === columns) {
      column = 0;
      [above, row] = [row, above];
      row.clear();
    }
    const here = column + 1;
    const moved = bit(MOVED + row.moved[column] + above.moved[here] + (above.moved[column] | above.moved[here + 1])
      + (changed[i] ? 4 : 0) + (x[i] === 0 && y[i] === 0 ? 0 : 8));
    const turned = bit(TURNED + row.turned[column] + above.turned[here] + (moved && confidence[i] === 0 ? 1 : 0));
    row.moved[here] = moved;
    row.turned[here] = turned;
    if (moved) {
      const guessX = expected(x, confidence, i, column, columns);
      const guessY = expected(y, confidence, i, column, columns);
      const offX = row.x[here] = number(X + NUMBER_SIZE * sizeClass(row.x[column], above.x[here]));
      const offY = row.y[here] = number(Y + NUMBER_SIZE * sizeClass(row.y[column] + offX, above.y[here]));
      x[i] = limited(guessX + offX);
      y[i] = limited(guessY + offY);
    }
    if (turned) confidence[i] = clamp(confidence[i] + turn(row, above, column), 0, LARGEST_CONFIDENCE);
    changed[i] = moved;
  }
}

function turn(row, above, column) {
  const left = row.confidence[column], up = above.confidence[column + 1];
  const guess = !above.turned[column + 1] ? left : !row.turned[column] ? up
    : clamp(left + up - above.confidence[column], Math.min(left, up), Math.max(left, up));
  return row.confidence[column + 1] = guess + number(CONFIDENCE + (left === up ? NUMBER_SIZE : 0));
}

// What the code does with the cells of a kind of field.
const MOTION = {
  fresh: FRESH,
  step: 0, // µm, the largest of a height: there is none
  // `x` and `y`: the velocity as its number on the scale.
  make: count => ({
    x: new Int16Array(count), y: new Int16Array(count), confidence: new Uint8Array(count),
    changed: new Uint8Array(count),
  }),
  decode: decodeCells,
  // What the checksum holds of each cell.
  hashed: ({ x, y, confidence }) => [x, y, confidence],
  // Velocities in px/s, y down.
  values({ cells, unit }) {
    const velocity = n => n < 0 ? -SPEEDS[-n] * unit : SPEEDS[n] * unit; // the array rounds
    return {
      x: Float32Array.from(cells.x, velocity), y: Float32Array.from(cells.y, velocity),
      confidence: Float32Array.from(cells.confidence, n => n / LARGEST_CONFIDENCE),
    };
  },
};

// ---- the bytes around them

class Reader {
  constructor(input) {
    this.input = input;
    this.at = 0;
    this.failed = false;
  }
  byte() {
    if (this.at < this.input.length) return this.input[this.at++];
    this.failed = true;
    return 0;
  }
  // Seven bits a byte, lowest first, 63 bits at most. In two halves, as a double has 53 bits.
  number(largest) {
    const HALF = 2 ** 28;
    let low = 0, high = 0;
    for (let i = 0; i < 9; ++i) {
      const byte = this.byte();
      if (i < 4) low += (byte & 0x7F) * 2 ** (7 * i);
      else high += (byte & 0x7F) * 2 ** (7 * (i - 4));
      if (byte < 0x80) {
        const most = Math.floor(largest / HALF);
        if (high > most || (high === most && low > largest % HALF)) this.failed = true;
        return this.failed ? 0 : high * HALF + low;
      }
    }
    this.failed = true;
    return 0;
  }
}

/** @returns whether a coded field and all after it can be decoded without those before it */
export const beginsPair = code => (code[0] & (KEY | OF_PAIR)) === KEY;

const hasScale = head => (head & KEY) !== 0 && ((head & OF_PAIR) !== 0 || !(head & INTERVAL));

// FNV-1a of the first byte and of what both sides hold, folded to 16 bits.
function checkOf(kind, head, state) {
  let hash = 2166136261;
  const add = value => { hash = Math.imul(hash ^ value, 16777619); };
  add(head);
  add(state.sequence);
  add(state.interval % 2 ** 32 | 0);
  if (hasScale(head)) add(state.scale % 2 ** 32 | 0);
  if (state.step) GRID.forEach(name => add(state[name]));
  const cells = kind.hashed(state.cells);
  for (let i = 0; i < cells[0].length; ++i)
    for (const numbers of cells) add(numbers[i] & 0xFFFF);
  return (hash ^ hash >>> 16) & 0xFFFF;
}

const GRID = ['columns', 'rows', 'width', 'height', 'aspectN', 'aspectD', 'step'];

function readGrid(kind, reader, head, state) {
  state.scale = hasScale(head) ? reader.number(LONGEST_INTERVAL) : state.interval;
  const names = kind.step ? GRID : GRID.slice(0, -1);
  names.forEach((name, i) => { state[name] = reader.number(i < 2 ? MOST_CELLS : i < 6 ? MOST_32 : kind.step); });
  const count = state.columns * state.rows;
  if (reader.failed || count > MOST_CELLS || names.some(name => !state[name])) return false;
  state.unit = unitOf(state.scale);
  state.cells = kind.make(count);
  return true;
}

const copyOf = cells => Object.fromEntries(Object.entries(cells).map(([name, numbers]) => [name, numbers.slice()]));

// Returns a field: the interval in µs, the frame in px.
function fieldOf(kind, state) {
  const { flags, interval, columns, rows, width, height, aspectN, aspectD } = state;
  return { flags, interval, columns, rows, width, height, aspectN, aspectD, ...kind.values(state) };
}

export class FieldDecoder {
  #kind;
  #state = null; // of the last field
  #keys = [null, null]; // the last two key fields, the older one first
  #sequence = null;
  field = null; // the last one that was decoded
  /** Fields between the last two of push() were lost. */
  lost = false;
  /** The field without motion before the last one, if fields were left out because the frame rested. */
  rest = null;
  /** How many were decoded so far. */
  cells = 0;

  constructor(kind = MOTION) { this.#kind = kind; }

  /** The next field has to be a key field. */
  forget() {
    this.#state = this.#sequence = this.field = this.rest = null;
    this.#keys = [null, null];
    this.lost = false;
  }

  /** @returns 'field' if `field` is the new one, else 'missing', 'waiting' or 'damaged'. */
  push(code) {
    const reader = new Reader(code);
    const head = reader.byte(), sequence = reader.byte();
    const key = (head & KEY) !== 0;
    this.rest = null;
    this.lost = false;
    if (reader.failed) return 'damaged';
    const begins = beginsPair(code) && sequence === FIRST_SEQUENCE; // a sender that was restarted
    if (this.#sequence !== null && !begins)
      this.lost = sequence !== this.#sequence && sequence !== (this.#sequence + 1 & 0xFF);
    if (this.#sequence !== null || key) this.#sequence = sequence;
    const next = { interval: 0 };
    if (!key) {
      const reference = this.#reference(head, sequence, head & OF_PAIR ? reader.byte() : 0);
      if (!reference) return this.#state ? 'missing' : 'waiting';
      Object.assign(next, reference, { cells: copyOf(reference.cells) });
    }
    next.sequence = sequence;
    next.flags = head >> FLAG_SHIFT;
    if (key || head & INTERVAL) next.interval = reader.number(LONGEST_INTERVAL);
    if (key && !readGrid(this.#kind, reader, head, next)) return 'damaged';
    const check = reader.byte() | reader.byte() << 8;
    if (reader.failed) return 'damaged';
    this.cells += next.columns * next.rows;
    begin(code, reader.at, this.#kind.fresh);
    this.#kind.decode(next.cells, next.columns);
    if (check !== checkOf(this.#kind, head, next)) return 'damaged';
    if ((head & RESTED) && this.#state) this.#setRest();
    this.#state = next;
    this.field = fieldOf(this.#kind, next);
    if (key) this.#keys = [this.#keys[1], next];
    return 'field';
  }

  #reference(head, sequence, distance) {
    const is = (state, number) => state && state.sequence === (number & 0xFF);
    if (!(head & OF_PAIR)) return is(this.#state, sequence - 1) ? this.#state : null;
    return [this.#keys[1], this.#keys[0]].find(state => is(state, sequence - distance)) ?? null;
  }

  #setRest() {
    const { x, y } = this.field; // of motion
    this.rest = { ...this.field, flags: STILL, x: x?.map(() => 0), y: y?.map(() => 0) };
  }
}
