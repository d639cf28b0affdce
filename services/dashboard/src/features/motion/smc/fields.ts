import type { Beside } from "./borders";
import { LinkWeights, type Outside, type PairingTree } from "./pairing";
import { BINS, type RangeDecoder } from "./rangeCoder";
import { Trellis } from "./trellis";

/** How many contexts there are of each kind, and where each kind begins: section 5.2 of api_schema/smc.md. */
const KINDS = [288, 256, 256, 256, 128, 768, 256, 256];
const BASES = KINDS.map((_, kind) => KINDS.slice(0, kind).reduce((sum, size) => sum + size, 0));
const CONTEXTS = KINDS.reduce((sum, size) => sum + size, 0);
/** Of a stream with plain quantisation; of one with dependent quantisation twice as many. */
export const FIELD_SLOTS = CONTEXTS * BINS;
export const FIELD_ROWS = 24;

export function scale(x: number): number {
  if (x < 6) return x;
  if (x >= 256) return 15;
  const length = 32 - Math.clz32(x);
  return Math.min(2 * length + ((x >> (length - 2)) & 1), 15);
}

/** After how many modes links are weighted anew; the first edition of the stream knows the first number only. */
const GUIDES = [3, 6, 12, 24];

/** Of the second edition of the stream: what is known of the vertices beside the cluster, spread over its tree. */
function spread({ children, levels }: PairingTree, beside: Beside): Outside {
  const nodes = 2 * levels.length + 1;
  const counts = new Float64Array(nodes);
  counts.set(beside.counts);
  levels.forEach((_, pair) => {
    const [a, b] = [children[2 * pair] as number, children[2 * pair + 1] as number];
    counts[levels.length + 1 + pair] = (counts[a] as number) + (counts[b] as number);
  });
  return { counts, weights: counts.slice(), means: new Float64Array(nodes) };
}

/**
 * Decode a cluster's fields in units of the step: `rank` rows of as many values as it has vertices.
 *
 * `beside` is what earlier clusters tell in the second edition of the stream; the first has none.
 */
export function decodeFields(
  decoder: RangeDecoder,
  tree: PairingTree,
  rank: number,
  beside: Beside | null,
  dependent: boolean,
): Float64Array {
  const { children, levels, sizes, parents, links, linkStarts } = tree;
  const outside = beside && spread(tree, beside);
  const weights = new LinkWeights(tree, outside);
  const { links: linkWeights, inner: innerWeights } = weights;
  const agreed = new Float64Array(12);
  const tried = new Float64Array(12);
  const pairs = levels.length;
  const n = pairs + 1;
  const means = new Float64Array(n + pairs);
  const fields = new Float64Array(rank * n);
  const nothing = new Int32Array(pairs + 1);
  // Magnitudes of this mode and of the modes before it, the latest first.
  let now = nothing;
  let earlier: Int32Array[] = [];
  const trellis = new Trellis(dependent);
  const { contexts } = decoder;
  const context = (kind: number, at: number) => (contexts[kind] = (BASES[kind] ?? 0) + at + trellis.odd * CONTEXTS);

  const optimum = (pair: number, center: number): number => {
    const sizeA = sizes[children[2 * pair] ?? 0] ?? 0;
    const sizeB = sizes[children[2 * pair + 1] ?? 0] ?? 0;
    const whole = sizeA + sizeB;
    const shareA = sizeB / whole;
    const shareB = sizeA / whole;
    let pull = 0;
    let stiffness = innerWeights[pair] ?? 0;
    const middle = linkStarts[2 * pair + 1] ?? 0;
    for (let e = linkStarts[2 * pair] ?? 0; e < middle; e += 1) {
      const u = shareA * (linkWeights[e] ?? 0);
      pull += u * ((means[links[e] ?? 0] ?? 0) - center);
      stiffness += shareA * u;
    }
    for (let e = middle; e < (linkStarts[2 * pair + 2] ?? 0); e += 1) {
      const u = shareB * (linkWeights[e] ?? 0);
      pull -= u * ((means[links[e] ?? 0] ?? 0) - center);
      stiffness += shareB * u;
    }
    if (outside) {
      const a = children[2 * pair] as number;
      const b = children[2 * pair + 1] as number;
      if ((outside.weights[a] as number) > 0) {
        const u = shareA * (outside.weights[a] as number);
        pull += u * ((outside.means[a] as number) - center);
        stiffness += shareA * u;
      }
      if ((outside.weights[b] as number) > 0) {
        const u = shareB * (outside.weights[b] as number);
        pull -= u * ((outside.means[b] as number) - center);
        stiffness += shareB * u;
      }
    }
    return stiffness > 0 ? pull / stiffness : 0;
  };
  const part = (pair: number, center: number, difference: number) => {
    const a = children[2 * pair] ?? 0;
    const b = children[2 * pair + 1] ?? 0;
    const whole = (sizes[a] ?? 0) + (sizes[b] ?? 0);
    means[a] = center + ((sizes[b] ?? 0) / whole) * difference;
    means[b] = center - ((sizes[a] ?? 0) / whole) * difference;
  };

  for (let mode = 0; mode < rank; mode += 1) {
    now = new Int32Array(pairs + 1);
    const [e1s = nothing, e2s = nothing, e3s = nothing] = earlier;
    trellis.restart();
    const running = new Float64Array(12).fill(64);
    const modeSmall = Math.min(mode, 23);
    for (let d = 0; d < 12; d += 1) {
      agreed[d] = 0.5 * (agreed[d] as number) + 5;
      tried[d] = 0.5 * (tried[d] as number) + 5;
    }
    if (outside && beside) {
      const { counts, means: there } = outside;
      there.set(beside.means.subarray(mode * n, (mode + 1) * n));
      for (let pair = 0; pair < pairs; pair += 1) {
        const [a, b] = [children[2 * pair] as number, children[2 * pair + 1] as number];
        const count = counts[n + pair] as number;
        const total = (counts[a] as number) * (there[a] as number) + (counts[b] as number) * (there[b] as number);
        there[n + pair] = count > 0 ? total / count : 0;
      }
    }
    for (let kind = 1; kind < 8; kind += 1) context(kind, kind % 2 ? Math.min(mode, 15) : 0);
    context(0, 264 + modeSmall);
    const value = decoder.value(0, 8, -1);
    now[pairs] = Math.abs(value);
    means[n + pairs - 1] = value / Math.sqrt(n);

    for (let high = pairs; high > 0;) {
      const level = levels[high - 1] ?? 0;
      let low = high;
      while (low > 0 && levels[low - 1] === level) low -= 1;
      for (let pair = low; pair < high; pair += 1) {
        const center = means[n + pair] ?? 0;
        means[children[2 * pair] ?? 0] = center;
        means[children[2 * pair + 1] ?? 0] = center;
      }
      for (let sweep = 0; sweep < 3; sweep += 1) {
        for (let pair = low; pair < high; pair += 1) {
          const center = means[n + pair] ?? 0;
          part(pair, center, optimum(pair, center));
        }
      }
      const depth = Math.min(level, 10);
      for (let pair = low; pair < high; pair += 1) {
        const center = means[n + pair] ?? 0;
        const sizeA = sizes[children[2 * pair] ?? 0] ?? 0;
        const sizeB = sizes[children[2 * pair + 1] ?? 0] ?? 0;
        const gain = Math.sqrt(sizeA * (sizeB / (sizeA + sizeB)));
        const plain = gain * optimum(pair, center);
        const trust = (agreed[depth] as number) / (tried[depth] as number);
        const guess = outside ? plain * Math.min(Math.max(trust, 0), 1.3) : plain;
        let near = 0;
        let count = 0;
        let past = 0;
        const begin = linkStarts[2 * pair] ?? 0;
        const end = linkStarts[2 * pair + 2] ?? 0;
        for (let e = begin; e < end; e += 1) {
          const y = parents[links[e] ?? 0] ?? 0;
          past += e1s[y] ?? 0;
          if ((y >= low && y < pair) || y >= high) {
            near += now[y] ?? 0;
            count += 1;
          }
        }
        const width = end - begin;
        const up = now[parents[n + pair] ?? 0] ?? 0;
        const e1 = e1s[pair] as number;
        const e2 = e2s[pair] as number;
        const e3 = e3s[pair] as number;
        const beside = count > 0 ? scale(Math.floor((4 * near) / count)) : 15;
        const prior = width > 0 ? scale(Math.floor((4 * past) / width)) : 0;
        const mean = scale(Math.floor((running[depth] ?? 0) / 16));
        const around = count > 0 ? Math.floor((8 * near) / count) : 4 * up;
        let long = 0;
        if (dependent && earlier.length) {
          for (let k = 0; k < earlier.length; k += 1) long += (earlier[k] as Int32Array)[pair] as number;
          long = Math.floor((8 * long) / earlier.length);
        }
        const blend = scale(Math.floor(around / 4) + up + e1 + Math.floor(e2 / 2) + Math.floor(long / 8));
        context(0, 24 * depth + modeSmall);
        context(1, 16 * beside + depth);
        context(2, 16 * scale(4 * e1) + scale(2 * (e2 + e3)));
        context(3, 16 * scale(4 * up) + beside);
        context(4, 8 * blend + Math.min(depth, 7));
        context(5, 3 * (16 * mean + beside) + Math.min(e1, 2));
        if (dependent) context(6, 16 * scale(long) + beside);
        else context(6, 4 * Math.min(mode, 63) + Math.min(depth, 3));
        context(7, 16 * prior + mean);
        const rows = trellis.odd * FIELD_ROWS;
        const coded = decoder.value(rows + 1 + Math.min(depth, 6), rows + 8 + blend, -1);
        const given = 0.5 * trellis.level(coded);
        const magnitude = Math.abs(coded);
        now[pair] = magnitude;
        const m = running[depth] ?? 0;
        running[depth] = m + Math.floor((256 * magnitude - 4 * m + 32) / 64);
        agreed[depth] = (agreed[depth] as number) + plain * (guess + given);
        tried[depth] = (tried[depth] as number) + plain * plain;
        part(pair, center, (guess + given) / gain);
      }
      high = low;
    }
    fields.set(means.subarray(0, n), mode * n);
    if (mode < (outside ? 24 : 3)) weights.add(means);
    if (outside ? GUIDES.includes(mode + 1) : mode === 2) weights.update();
    earlier = [now, ...earlier.slice(0, 7)];
  }
  return fields;
}
