import { type Decoded, inRows, lookBeyond } from "./borders";
import { CorruptMotion } from "./container";
import { decodeFields, FIELD_ROWS, FIELD_SLOTS } from "./fields";
import { decodeFunctions, FUNCTION_ROWS, FUNCTION_SLOTS, SIGN_SLOTS } from "./functions";
import { type Graph, subgraph } from "./graph";
import { pairingTree } from "./pairing";
import { RangeDecoder } from "./rangeCoder";
import { DEPENDENT_PACE } from "./trellis";

/** Slots of TMOD: section 5 of api_schema/smc.md. */
const FRAME = 0;
const LABEL = FRAME + 8;
const RANK = LABEL + 56;
const RUNS = RANK + 64;
const LENGTH = RUNS + 64;
const MODEL_SLOTS = LENGTH + 64;

/** The streams of fields: with dependent quantisation, and as versions 1.2, 1.1 and 1.0 have them. */
const EDITIONS = ["TFL4", "TFL3", "TFL2", "TFLD"];

interface Cluster {
  members: Int32Array;
  rank: number;
  /** rank · members, in the unit of the coordinates. */
  fields: Float64Array;
  /** frames · rank · 3. */
  functions: Float64Array;
}

/** A group of the profile `trajectory`, decoded as far as its frames need. */
export class TrajectoryGroup {
  readonly #kept: Int32Array;
  readonly #offset: readonly number[];
  readonly #clusters: Cluster[];
  readonly labels: Int32Array;

  constructor(
    sections: ReadonlyMap<string, Uint8Array>,
    frames: number,
    vertices: number,
    graph: Graph,
    memory: number,
  ) {
    const section = (tag: string): Uint8Array => {
      const payload = sections.get(tag);
      if (!payload) throw new CorruptMotion(tag, "is not there");
      return payload;
    };
    const named = <T>(tag: string, work: () => T): T => {
      try {
        return work();
      } catch (error) {
        if (error instanceof RangeError) throw new CorruptMotion(tag, error.message);
        throw error;
      }
    };
    const head = section("TMOD");
    if (head.length < 44) throw new CorruptMotion("TMOD", "is too short");
    const view = new DataView(head.buffer, head.byteOffset, head.length);
    this.#offset = [0, 8, 16].map((at) => view.getFloat64(at, true));
    const step = view.getFloat64(24, true);
    const kept = view.getUint32(32, true);
    const count = view.getUint32(36, true);
    const runsTogether = view.getUint32(40, true);
    if (this.#offset.some((value) => !(Math.abs(value) <= 1e30)) || !(step > 0 && step <= 1e30)) {
      throw new CorruptMotion("TMOD", "has a step or an offset that no encoder writes");
    }
    if (kept < 1 || kept > frames || count < 1 || count > vertices || runsTogether > count * kept) {
      throw new CorruptMotion("TMOD", "tells of more than there can be");
    }
    const model = named("TMOD", () => readModel(head.subarray(44), frames, vertices, graph, kept, count));
    this.#kept = model.kept;
    this.labels = model.labels;
    const members = gather(model.labels, count);
    if (members.some((some) => some.length === 0)) throw new CorruptMotion("TMOD", "has a cluster without vertices");
    const ranks = model.ranks;
    const needed = members.reduce(
      (sum, some, k) => sum + (ranks[k] ?? 0) * (16 * some.length + 48 * kept),
      400 * vertices,
    );
    if (needed > memory) throw new CorruptMotion("TMOD", "asks for more memory than the header tells");

    const tag = EDITIONS.find((edition) => sections.has(edition)) ?? "TFL3";
    const dependent = tag === "TFL4";
    const [sets, pace] = dependent ? [2, DEPENDENT_PACE] : [1, undefined];
    const basesTag = dependent ? "TBA2" : "TBAS";
    const time = new RangeDecoder(section(basesTag), sets * FUNCTION_SLOTS + SIGN_SLOTS, sets * FUNCTION_ROWS, pace);
    const functions = named(basesTag, () =>
      model.runs.map((runs, k) => decodeFunctions(time, runs, ranks[k] ?? 0, dependent)),
    );
    const space = new RangeDecoder(section(tag), sets * FIELD_SLOTS, sets * FIELD_ROWS, pace);
    const place = new Int32Array(vertices);
    for (const some of members) some.forEach((v, index) => (place[v] = index));
    const done: Decoded[] = [];
    this.#clusters = named(tag, () =>
      members.map((some, k) => {
        const rank = ranks[k] ?? 0;
        const { values, first } = functions[k] ?? { values: new Float64Array(0), first: 0 };
        const tree = pairingTree(subgraph(graph, some, place, model.labels));
        if (tag === "TFLD")
          return { members: some, rank, fields: decodeFields(space, tree, rank, null, false), functions: values };
        const rows = inRows(values, rank);
        const n = some.length;
        const fields = new Float64Array(rank * n);
        // from the third edition on the first function is the cluster's mean trajectory
        const means = tag === "TFL3" || dependent ? Math.min(rank, 1) : 0;
        const length = rank > 0 ? rows.length / rank : 0;
        const level = first / Math.sqrt(n);
        const mean = rows.subarray(0, means * length).map((value) => level * value);
        const others = rows.subarray(means * length);
        const beside = lookBeyond(graph, some, model.labels, place, done, rank - means, others, mean);
        if (means) fields.fill(level, 0, n);
        if (rank > means) fields.set(decodeFields(space, tree, rank - means, beside, dependent), means * n);
        done.push({ rank, vertices: n, fields, rows });
        return { members: some, rank, fields, functions: values };
      }),
    );
    for (const { fields } of this.#clusters) fields.forEach((value, at) => (fields[at] = value * step));
  }

  /** Write the vertices of a frame of the group. */
  frame(index: number, into: Float64Array): void {
    const t = this.#kept[index] ?? 0;
    const [ox = 0, oy = 0, oz = 0] = this.#offset;
    for (const { members, rank, fields, functions } of this.#clusters) {
      const n = members.length;
      for (let v = 0; v < n; v += 1) {
        let [x, y, z] = [0, 0, 0];
        for (let mode = 0, at = t * rank * 3; mode < rank; mode += 1, at += 3) {
          const value = fields[mode * n + v] as number;
          x += value * (functions[at] as number);
          y += value * (functions[at + 1] as number);
          z += value * (functions[at + 2] as number);
        }
        const to = 3 * (members[v] as number);
        into[to] = ox + x;
        into[to + 1] = oy + y;
        into[to + 2] = oz + z;
      }
    }
  }
}

function readModel(
  stream: Uint8Array,
  frames: number,
  vertices: number,
  { starts, neighbours }: Graph,
  keptFrames: number,
  count: number,
) {
  const decoder = new RangeDecoder(stream, MODEL_SLOTS);
  const kept = new Int32Array(frames);
  let [soFar, before] = [0, 0];
  for (let frame = 0; frame < frames; frame += 1) {
    before = decoder.bit(FRAME + before);
    if (before) {
      if (soFar === 0) throw new RangeError("repeats a frame that is not there");
      kept[frame] = decoder.below(soFar);
    } else {
      kept[frame] = soFar;
      soFar += 1;
    }
  }
  if (soFar !== keptFrames) throw new RangeError("keeps another number of frames than it tells");
  const ranks = Array.from({ length: count }, () => decoder.number(RANK));
  if (ranks.some((rank) => rank > 3 * keptFrames + 1)) throw new RangeError("has more modes than frames");
  const runs = ranks.map(() => {
    const lengths: number[] = [];
    for (let rest = keptFrames, j = 0; rest > 0; j += 1) {
      const length = decoder.bit(RUNS + Math.min(j, 7)) ? rest : decoder.number(LENGTH) + 1;
      if (length > rest) throw new RangeError("has a run that is too long");
      lengths.push(length);
      rest -= length;
    }
    return lengths;
  });
  const labels = new Int32Array(vertices);
  const borne = new Map<number, number>();
  for (let v = 0; v < vertices; v += 1) {
    borne.clear();
    let first = v > 0 ? (labels[v - 1] ?? 0) : 0;
    let [firstCount, second, secondCount] = [0, -1, 0];
    for (let e = starts[v] ?? 0; e < (starts[v + 1] ?? 0); e += 1) {
      const other = neighbours[e] ?? 0;
      if (other >= v) break;
      borne.set(labels[other] ?? 0, (borne.get(labels[other] ?? 0) ?? 0) + 1);
    }
    for (let e = starts[v] ?? 0; e < (starts[v + 1] ?? 0); e += 1) {
      const other = neighbours[e] ?? 0;
      if (other >= v) break;
      const l = labels[other] ?? 0;
      const c = borne.get(l) ?? 0;
      if (c > firstCount) {
        if (l !== first && firstCount !== 0) [second, secondCount] = [first, firstCount];
        [first, firstCount] = [l, c];
      } else if (l !== first && c > secondCount) {
        [second, secondCount] = [l, c];
      }
    }
    if (decoder.bit(LABEL + 3 * Math.min(firstCount, 5) + Math.min(secondCount, 2))) labels[v] = first;
    else if (second >= 0 && decoder.bit(LABEL + 20 + Math.min(secondCount, 3))) labels[v] = second;
    else labels[v] = decoder.below(count);
  }
  return { kept, ranks, runs, labels };
}

function gather(labels: Int32Array, count: number): Int32Array[] {
  const members: number[][] = Array.from({ length: count }, () => []);
  labels.forEach((label, v) => members[label]?.push(v));
  return members.map((some) => Int32Array.from(some));
}
