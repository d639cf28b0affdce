import { scale } from "./fields";
import { BINS, bits, type RangeDecoder } from "./rangeCoder";
import { Trellis } from "./trellis";

/** How many contexts there are of each kind, and where each kind begins: section 5.1 of api_schema/smc.md. */
const KINDS = [480, 256, 256, 256, 320, 768, 384, 256];
const BASES = KINDS.map((_, kind) => KINDS.slice(0, kind).reduce((sum, size) => sum + size, 0));
const CONTEXTS = KINDS.reduce((sum, size) => sum + size, 0);
/** Of a stream with plain quantisation; of one with dependent quantisation twice as many, but for the signs. */
export const FUNCTION_SLOTS = CONTEXTS * BINS;
export const SIGN_SLOTS = 72;
export const FUNCTION_ROWS = 24;

function band(f: number): number {
  if (f < 4) return f;
  const length = bits(f);
  return Math.min(2 * length + ((f >> (length - 2)) & 1) - 2, 19);
}

export interface Functions {
  /** `frames` · `rank` · 3 values: where mode i stands at frame t is 3 (t · rank + i). */
  values: Float64Array;
  /** The norm of the first mode's coefficients, in steps. */
  first: number;
}

/** Decode a cluster's functions of time. */
export function decodeFunctions(
  decoder: RangeDecoder,
  runs: readonly number[],
  rank: number,
  dependent: boolean,
): Functions {
  const frames = runs.reduce((sum, length) => sum + length, 0);
  const coefficients = decodeCoefficients(decoder, runs, rank, frames, dependent);
  const values = new Float64Array(frames * rank * 3);
  const norms = Float64Array.from({ length: rank }, (_, mode) => {
    let total = 0;
    for (let at = mode * frames * 3; at < (mode + 1) * frames * 3; at += 1) total += (coefficients[at] ?? 0) ** 2;
    return Math.sqrt(total);
  });
  const scales = norms.map((norm) => (norm > 0 ? 1 / norm : 0));
  let first = 0;
  for (const length of runs) {
    const table = Float64Array.from({ length: 4 * length }, (_, k) => Math.cos((Math.PI * k) / (2 * length)));
    for (let f = 0; f < length; f += 1) {
      const factor = f > 0 ? Math.sqrt(2 / length) : Math.sqrt(1 / length);
      for (let mode = 0; mode < rank; mode += 1) {
        const weight = factor * (scales[mode] ?? 0);
        for (let axis = 0; axis < 3; axis += 1) {
          const q = coefficients[(mode * frames + first + f) * 3 + axis] ?? 0;
          if (q === 0) continue;
          for (let t = 0; t < length; t += 1) {
            const at = ((first + t) * rank + mode) * 3 + axis;
            values[at] = (values[at] ?? 0) + (table[((2 * t + 1) * f) % (4 * length)] ?? 0) * (q * weight);
          }
        }
      }
    }
    first += length;
  }
  return { values, first: 0.5 * (norms[0] ?? 0) };
}

function decodeCoefficients(
  decoder: RangeDecoder,
  runs: readonly number[],
  rank: number,
  frames: number,
  dependent: boolean,
): Int32Array {
  const q = new Int32Array(rank * frames * 3);
  const levels = new Int32Array(q.length);
  const trellis = new Trellis(dependent);
  const signs = (dependent ? 2 : 1) * FUNCTION_SLOTS;
  const { contexts } = decoder;
  const context = (kind: number, at: number) => (contexts[kind] = (BASES[kind] ?? 0) + at + trellis.odd * CONTEXTS);
  const running = new Float64Array(20);
  const wholes = new Int32Array(rank * frames);
  const memory = new Float64Array(frames);
  for (let mode = 0; mode < rank; mode += 1) {
    for (let b = 0; b < 20; b += 1) running[b] = mode === 0 ? 64 : Math.floor(((running[b] ?? 0) + 64) / 2);
    trellis.restart();
    // Of each frequency of all runs: the magnitudes of up to eight modes before, all axes together.
    const past = Math.min(mode, 8);
    for (let at = 0; at < frames; at += 1) {
      let total = 0;
      for (let i = mode - past; i < mode; i += 1) total += wholes[i * frames + at] as number;
      memory[at] = total;
    }
    let first = 0;
    for (const length of runs) {
      /** The magnitude of mode `i` at frequency `f` of this run; 0 where there is none. */
      const size = (i: number, f: number, axis: number) =>
        i < 0 || f < 0 || f >= length ? 0 : Math.abs(q[(i * frames + first + f) * 3 + axis] ?? 0);
      const whole = (i: number, f: number) => (i < 0 || f >= length ? 0 : (wholes[i * frames + first + f] as number));
      const sign = (f: number, axis: number) => {
        const value = f < 0 ? 0 : (q[(mode * frames + first + f) * 3 + axis] ?? 0);
        return value > 0 ? 1 : value < 0 ? 2 : 0;
      };
      for (let f = 0; f < length; f += 1) {
        const at = band(f);
        for (let x = 0; x < 3; x += 1) {
          const low1 = size(mode, f - 1, x);
          const low2 = size(mode, f - 2, x);
          let beside = 0;
          let around = 0;
          for (let y = 0; y < x; y += 1) beside += size(mode, f, y);
          for (let y = x; y < 3; y += 1) around += size(mode, f - 1, y);
          const e1 = size(mode - 1, f, x);
          const e2 = size(mode - 2, f, x);
          const all1 = whole(mode - 1, f);
          const all2 = whole(mode - 2, f);
          const ahead = whole(mode - 1, f + 1);
          const near = f > 0 ? scale(Math.floor((4 * (2 * low1 + low2)) / 3)) : 15;
          let cross = 15;
          if (f > 0) cross = scale(Math.floor((4 * (beside + around)) / 3));
          else if (x > 0) cross = scale(Math.floor((4 * beside) / x));
          const mean = scale(Math.floor((running[at] ?? 0) / 16));
          let sum = 2 * low1 + low2 + 2 * beside + around + e1 + all1 + Math.floor(all2 / 2) + Math.floor(ahead / 2);
          let long = 0;
          if (dependent && mode > 0) {
            long = 2 * (memory[first + f] as number);
            if (f > 0) long += memory[first + f - 1] as number;
            if (f + 1 < length) long += memory[first + f + 1] as number;
            long = Math.floor(long / (3 * past));
            sum += Math.floor(long / 2);
          }
          const blend = scale(Math.floor(sum / 2));
          context(0, 24 * at + Math.min(mode, 23));
          context(1, 16 * near + cross);
          context(2, 16 * scale(4 * e1) + scale(4 * e2));
          context(3, 16 * scale(Math.floor((4 * all1) / 3)) + cross);
          context(4, 20 * blend + at);
          context(5, 3 * (16 * mean + cross) + x);
          if (dependent) context(6, 16 * scale(long) + cross);
          else context(6, 6 * Math.min(mode, 63) + Math.min(Math.floor(at / 3), 5));
          context(7, 16 * scale(Math.floor((4 * (all1 + all2 + ahead)) / 9)) + mean);
          const slot = signs + 9 * Math.min(f, 7) + 3 * sign(f - 1, x) + sign(f - 2, x);
          const rows = trellis.odd * FUNCTION_ROWS;
          const value = decoder.value(rows + Math.min(Math.floor(at / 2), 7), rows + 8 + blend, slot);
          q[(mode * frames + first + f) * 3 + x] = value;
          levels[(mode * frames + first + f) * 3 + x] = trellis.level(value);
          wholes[mode * frames + first + f] = (wholes[mode * frames + first + f] as number) + Math.abs(value);
          const m = running[at] ?? 0;
          running[at] = m + Math.floor((256 * Math.abs(value) - 4 * m + 32) / 64);
        }
      }
      first += length;
    }
  }
  return levels;
}
