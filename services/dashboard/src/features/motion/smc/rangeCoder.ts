/** The range coder of motion files: section 2 of api_schema/smc.md, whose names are kept. */

const MOST_BEYOND = 64;
const HALF = 32768;
const CONTEXTS = 8;
/** Slots of one context of `value`, and rows that one mixer row stands for. */
export const BINS = 32;

const RATES = Int32Array.from({ length: 256 }, (_, count) => Math.floor(131072 / (2 * count + 3)));

const KNOTS = [
  22, 36, 60, 98, 162, 267, 439, 720, 1179, 1921, 3108, 4971, 7812, 11955, 17625, 24743, 32768, 40793, 47911, 53581,
  57724, 60565, 62428, 63615, 64357, 64816, 65097, 65269, 65374, 65438, 65476, 65500, 65514,
];

/** squash(x), at x + 2048. */
const SQUASH = Int32Array.from({ length: 4096 }, (_, at) => {
  const i = at >> 7;
  const f = at & 127;
  return ((KNOTS[i] ?? 0) * (128 - f) + (KNOTS[i + 1] ?? 0) * f + 64) >> 7;
});

/** stretch(p), at p >> 4. */
const STRETCH = new Int32Array(4096);
for (let at = 0, x = 0; at < 4096; at += 1) {
  while (x < 4095 && (SQUASH[x] ?? 0) < 16 * at + 8) x += 1;
  STRETCH[at] = x - 2048;
}

/** len(x): the number of binary digits. */
export function bits(x: number): number {
  return x < 4294967296 ? 32 - Math.clz32(x) : 32 + bits(Math.floor(x / 4294967296));
}

/** Decodes one stream. */
export class RangeDecoder {
  readonly #bytes: Uint8Array;
  #at = 0;
  #low = 0;
  #high = 0xffffffff;
  #code = 0;
  readonly #probabilities: Int32Array;
  readonly #counts: Uint8Array;
  readonly #weights: Float64Array;
  readonly #pace: number;
  readonly #logits = new Int32Array(CONTEXTS);
  readonly #slots = new Int32Array(CONTEXTS);
  /** The contexts of the next `value`. */
  readonly contexts = new Int32Array(CONTEXTS);

  constructor(bytes: Uint8Array, slots: number, mixerRows = 0, pace = 8) {
    this.#bytes = bytes;
    this.#pace = pace;
    this.#probabilities = new Int32Array(slots).fill(HALF);
    this.#counts = new Uint8Array(slots);
    this.#weights = new Float64Array(mixerRows * BINS * 9).fill(6553);
    for (let row = 0; row < mixerRows * BINS; row += 1) this.#weights[row * 9 + 8] = 0;
    for (let byte = 0; byte < 4; byte += 1) this.#code = ((this.#code << 8) | this.#next()) >>> 0;
  }

  #next(): number {
    if (this.#at > this.#bytes.length + MOST_BEYOND) throw new RangeError("ends before all is decoded");
    const byte = this.#bytes[this.#at] ?? 0;
    this.#at += 1;
    return byte;
  }

  /** A bit whose probability of being 1 is p / 65536. */
  #decode(p: number): number {
    const spread = this.#high - this.#low;
    const middle = this.#low + (spread >>> 16) * p + (((spread & 65535) * p) >>> 16);
    const bit = this.#code <= middle ? 1 : 0;
    if (bit) this.#high = middle;
    else this.#low = middle + 1;
    while ((this.#low ^ this.#high) >>> 24 === 0) {
      this.#low = (this.#low << 8) >>> 0;
      this.#high = ((this.#high << 8) | 255) >>> 0;
      this.#code = ((this.#code << 8) | this.#next()) >>> 0;
    }
    return bit;
  }

  #learn(slot: number, bit: number): void {
    const p = this.#probabilities[slot] as number;
    const count = this.#counts[slot] as number;
    const rate = RATES[count] as number;
    // Products stay below 2^32: shifts round down as the specification does.
    this.#probabilities[slot] = bit ? p + (((65535 - p) * rate) >>> 16) : p - ((p * rate + 65535) >>> 16);
    if (count < 250) this.#counts[slot] = count + 1;
  }

  bit(slot: number): number {
    const p = this.#probabilities[slot] ?? HALF;
    const bit = this.#decode(Math.min(Math.max(p, 32), 65504));
    this.#learn(slot, bit);
    return bit;
  }

  raw(count: number): number {
    let value = 0;
    for (let k = 0; k < count; k += 1) value = value * 2 + this.#decode(HALF);
    return value;
  }

  number(slot: number): number {
    let ones = 0;
    while (ones < 31 && this.bit(slot + ones)) ones += 1;
    const digits = ones + 1;
    if (digits === 1) return 0;
    const second = this.bit(slot + 31 + digits);
    return (2 + second) * 2 ** (digits - 2) + this.raw(digits - 2) - 1;
  }

  below(limit: number): number {
    const value = this.raw(bits(limit - 1));
    if (value >= limit) throw new RangeError("names a number that is not there");
    return value;
  }

  /** A bit by the slots at `offset` in each of `contexts`, mixed by two rows. */
  #mixed(offset: number, rowA: number, rowB: number): number {
    const weights = this.#weights;
    const logits = this.#logits;
    const slots = this.#slots;
    const contexts = this.contexts;
    const probabilities = this.#probabilities;
    const u = (rowA * BINS + offset) * 9;
    const v = (rowB * BINS + offset) * 9;
    let sum = ((weights[u + 8] as number) + (weights[v + 8] as number)) * 256;
    for (let k = 0; k < CONTEXTS; k += 1) {
      const slot = (contexts[k] as number) * BINS + offset;
      const logit = STRETCH[(probabilities[slot] as number) >> 4] as number;
      slots[k] = slot;
      logits[k] = logit;
      sum += ((weights[u + k] as number) + (weights[v + k] as number)) * logit;
    }
    const x = Math.min(Math.max(Math.floor(sum / 65536), -2048), 2047);
    const p = Math.min(Math.max(SQUASH[x + 2048] as number, 32), 65504);
    const bit = this.#decode(p);
    const e = ((bit ? 65536 : 0) - p) * this.#pace;
    // Logits are below 2^11 and errors below 2^20: the products fit 32 bits.
    for (let k = 0; k < CONTEXTS; k += 1) {
      const g = ((logits[k] as number) * e + 524288) >> 20;
      weights[u + k] = (weights[u + k] as number) + g;
      weights[v + k] = (weights[v + k] as number) + g;
      this.#learn(slots[k] as number, bit);
    }
    const g = (256 * e + 524288) >> 20;
    weights[u + 8] = (weights[u + 8] as number) + g;
    weights[v + 8] = (weights[v + 8] as number) + g;
    return bit;
  }

  /** A whole number by `contexts` and two mixer rows; its sign by an adaptive slot, or raw where that is -1. */
  value(rowA: number, rowB: number, sign: number): number {
    let digits = 0;
    while (digits < 24 && this.#mixed(digits, rowA, rowB)) digits += 1;
    if (digits === 0) return 0;
    let magnitude = 1;
    let rest = digits - 1;
    if (digits >= 2 && digits <= 9) {
      magnitude = 2 + this.#mixed(22 + digits, rowA, rowB);
      rest -= 1;
    }
    magnitude = magnitude * 2 ** rest + this.raw(rest);
    const negative = sign < 0 ? this.raw(1) : this.bit(sign);
    return negative ? -magnitude : magnitude;
  }
}
