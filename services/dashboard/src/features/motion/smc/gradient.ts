import { CorruptMotion } from "./container";
import { Gluing } from "./gluing";
import { bits, RangeDecoder } from "./rangeCoder";
import { fromResiduals, type Traversal, traverse } from "./traversal";

const ENTRY = 8;
const FIXED = 32;
const [KEY, PREDICTED, CHANGES, LISTED] = [1, 2, 4, 8];
const FARTHEST = 2 ** 40;
const PATTERNS = 128;
const TREES = 3 * PATTERNS;

interface KeyFrame {
  /** Whole multiples of the step. */
  positions: Float64Array;
  anchors: Int32Array;
}

interface PredictedFrame {
  key: KeyFrame;
  labels: Int32Array;
  matrices: Float64Array;
  held: Float64Array;
}

/** Whole numbers in rows of `columns`. */
class Numbers {
  readonly #decoder: RangeDecoder;
  readonly #columns: number;

  constructor(payload: Uint8Array, columns: number) {
    this.#decoder = new RangeDecoder(payload, columns * 16 * 40);
    this.#columns = columns;
  }

  rows(count: number): Float64Array {
    const values = new Float64Array(count * this.#columns);
    for (let at = 0; at < values.length; at += 1) {
      const column = at % this.#columns;
      const above = at >= this.#columns ? Math.abs(values[at - this.#columns] as number) : 0;
      const left = column > 0 ? Math.abs(values[at - 1] as number) : 0;
      values[at] = this.#one(40 * (16 * column + Math.min(15, bits(above + left))));
    }
    return values;
  }

  #one(base: number): number {
    let length = 0;
    while (length < 31 && this.#decoder.bit(base + length)) length += 1;
    if (length === 0) return 0;
    let [magnitude, rest] = [1, length - 1];
    if (length >= 2 && length < 9) {
      magnitude = 2 + this.#decoder.bit(base + 31 + length);
      rest -= 1;
    }
    magnitude = magnitude * 2 ** rest + this.#decoder.raw(rest);
    return this.#decoder.raw(1) ? -magnitude : magnitude;
  }
}

/** A group of the profile `gradient`: key frames, and frames predicted from them. */
export class GradientGroup {
  /** For each vertex the cluster of its first face in the first predicted frame; 0 where there is none. */
  readonly labels: Int32Array;
  readonly #faces: ArrayLike<number>;
  readonly #origin: readonly number[];
  readonly #step: number;
  readonly #frames: (KeyFrame | PredictedFrame)[] = [];
  #system: { key: KeyFrame; anchors: number; gluing: Gluing; last: Float64Array } | null = null;

  constructor(
    sections: ReadonlyMap<string, Uint8Array>,
    frames: number,
    vertices: number,
    faces: ArrayLike<number>,
    memory: number,
  ) {
    const section = (tag: string): Uint8Array => {
      const payload = sections.get(tag);
      if (!payload) throw new CorruptMotion(tag, "is not there");
      return payload;
    };
    this.#faces = faces;
    const table = section("GFRM");
    if (table.length !== FIXED + ENTRY * frames) throw new CorruptMotion("GFRM", "does not fit the frames");
    const view = new DataView(table.buffer, table.byteOffset, table.length);
    this.#origin = [0, 8, 16].map((at) => view.getFloat64(at, true));
    this.#step = view.getFloat64(24, true);
    if (this.#origin.some((value) => !(Math.abs(value) <= 1e30)) || !(this.#step >= 1e-30 && this.#step <= 1e30)) {
      throw new CorruptMotion("GFRM", "has a grid that no encoder writes");
    }
    const entries = Array.from({ length: frames }, (_, k) => ({
      kind: view.getUint8(FIXED + ENTRY * k),
      precision: view.getInt8(FIXED + ENTRY * k + 1),
      count: view.getUint16(FIXED + ENTRY * k + 2, true) + 1,
      anchors: view.getUint32(FIXED + ENTRY * k + 4, true),
    }));
    const m = faces.length / 3;
    const predicted = entries.filter(({ kind }) => !(kind & KEY));
    const needed =
      28 * vertices * (frames - predicted.length) +
      predicted.reduce((sum, { count, anchors }) => sum + 4 * m + 72 * count + 24 * anchors, 0) +
      (predicted.length > 0 ? 4 * (3000 * vertices + 500 * m) : 0) +
      2 ** 20;
    if (needed > memory) throw new CorruptMotion("GFRM", "asks for more memory than the header tells");

    const walk = traverse(faces, vertices);
    const readers = {
      GKEY: new Numbers(section("GKEY"), 3),
      GLST: new Numbers(section("GLST"), 1),
      GANC: new Numbers(section("GANC"), 3),
      GMAT: new Numbers(section("GMAT"), 9),
    };
    const rows = (tag: keyof typeof readers, count: number): Float64Array => named(tag, () => readers[tag].rows(count));
    const labels = new Labels(section("GLAB"), walk, m);
    let key: KeyFrame | null = null;
    let held = new Float64Array(0);
    let before = { count: 0, precision: 0, matrices: new Float64Array(0) };
    for (const { kind, precision, count, anchors } of entries) {
      if (kind & KEY && (kind & ~(KEY | CHANGES | LISTED)) === 0) {
        const positions = fromResiduals(walk, rows("GKEY", vertices));
        if (kind & CHANGES) {
          const from: Float64Array | undefined = key?.positions;
          if (!from) throw new CorruptMotion("GFRM", "begins with changes from a frame before");
          positions.forEach((value, at) => (positions[at] = value + (from[at] as number)));
        }
        bounded("GKEY", positions);
        let chosen: Int32Array = key?.anchors ?? new Int32Array(0);
        if (kind & LISTED) chosen = anchorList(anchors, vertices, rows);
        if (chosen.length !== anchors) throw new CorruptMotion("GFRM", "tells of other anchors than there are");
        key = { positions, anchors: chosen };
        held = new Float64Array(3 * anchors);
        chosen.forEach((v, k) => held.set(positions.subarray(3 * v, 3 * v + 3), 3 * k));
        this.#frames.push(key);
      } else if (kind === PREDICTED && key && precision >= -100 && precision <= 60) {
        if (anchors > key.anchors.length) throw new CorruptMotion("GFRM", "tells of more anchors than there are");
        const moved = rows("GANC", anchors).map((value, at) => value + (held[at] as number));
        const shift = precision - before.precision;
        const known = before.count === count && Math.abs(shift) <= 20;
        const matrices = rows("GMAT", count).map(
          (value, at) => value + (known ? Math.floor((before.matrices[at] as number) * 2 ** shift) : 0),
        );
        bounded("GANC", moved);
        bounded("GMAT", matrices);
        held.set(moved);
        before = { count, precision, matrices };
        const exact = matrices.map(
          (value, at) => value * 2 ** -precision + (at % 9 === 0 || at % 9 === 4 || at % 9 === 8 ? 1 : 0),
        );
        this.#frames.push({ key, labels: named("GLAB", () => labels.read(count)), matrices: exact, held: moved });
      } else {
        throw new CorruptMotion("GFRM", "has an entry that is none");
      }
    }
    this.labels = new Int32Array(vertices);
    const first = this.#frames.find((frame) => "labels" in frame);
    for (let f = m - 1; f >= 0 && first; f -= 1) {
      for (let k = 0; k < 3; k += 1) this.labels[faces[3 * f + k] as number] = first.labels[f] as number;
    }
  }

  /** Write the vertices of a frame of the group. */
  frame(index: number, into: Float64Array): void {
    const found = this.#frames[index];
    if (!found) return;
    if (!("labels" in found)) {
      into.set(this.#placed(found.positions));
      return;
    }
    const anchors = found.held.length / 3;
    if (this.#system?.key !== found.key || this.#system.anchors !== anchors) {
      const points = this.#placed(found.key.positions);
      const gluing = new Gluing(this.#faces, points, found.key.anchors.subarray(0, anchors));
      this.#system = { key: found.key, anchors, gluing, last: points };
    }
    const { gluing, last } = this.#system;
    gluing.solve(found.labels, found.matrices, this.#placed(found.held), last);
    into.set(last);
  }

  #placed(multiples: Float64Array): Float64Array {
    return multiples.map((value, at) => (this.#origin[at % 3] as number) + this.#step * value);
  }
}

function named<T>(tag: string, work: () => T): T {
  try {
    return work();
  } catch (error) {
    if (error instanceof RangeError) throw new CorruptMotion(tag, error.message);
    throw error;
  }
}

function bounded(tag: string, values: Float64Array): void {
  if (values.some((value) => Math.abs(value) > FARTHEST))
    throw new CorruptMotion(tag, "has numbers that no encoder writes");
}

function anchorList(count: number, vertices: number, rows: (tag: "GLST", count: number) => Float64Array): Int32Array {
  if (count > vertices) throw new CorruptMotion("GFRM", "tells of more anchors than vertices");
  let at = 0;
  const list = rows("GLST", count).map((step) => (at += step));
  if (list.some((v) => v < 0 || v >= vertices) || new Set(list).size !== count) {
    throw new CorruptMotion("GLST", "names vertices that are not there, or one twice");
  }
  return Int32Array.from(list);
}

/** The clusters of the faces, frame after frame. */
class Labels {
  readonly #decoder: RangeDecoder;
  readonly #walk: Traversal;
  #previous: Int32Array;
  #count = 0;

  constructor(payload: Uint8Array, walk: Traversal, faces: number) {
    this.#decoder = new RangeDecoder(payload, TREES + 2 ** 17);
    this.#walk = walk;
    this.#previous = new Int32Array(faces);
  }

  read(count: number): Int32Array {
    const { across, faceOrder, parents, ranks } = this.#walk;
    const decoder = this.#decoder;
    const labels = new Int32Array(this.#previous.length);
    const steady = this.#count === count;
    const depth = bits(count - 1);
    for (let k = 0; k < faceOrder.length; k += 1) {
      const face = faceOrder[k] as number;
      const parent = parents[face] as number;
      const first = parent >= 0 ? (labels[parent] as number) : -1;
      let second = -1;
      for (let side = 0; side < 3; side += 1) {
        const other = across[3 * face + side] as number;
        if (other >= 0 && other !== parent && (ranks[other] as number) < k && labels[other] !== first) {
          second = labels[other] as number;
          break;
        }
      }
      const third = steady ? (this.#previous[face] as number) : -1;
      let pattern = (first >= 0 ? 1 : 0) + (second >= 0 ? 2 : 0);
      if (third >= 0) {
        const ofParent = parent >= 0 ? (this.#previous[parent] as number) : -2;
        pattern += 4 + (third === first ? 8 : 0) + (third === second ? 16 : 0);
        pattern += (ofParent === third ? 32 : 0) + (parent >= 0 && ofParent === first ? 64 : 0);
      }
      let found = -1;
      if (first >= 0 && decoder.bit(pattern)) found = first;
      if (found < 0 && second >= 0 && decoder.bit(PATTERNS + pattern)) found = second;
      if (found < 0 && third >= 0 && third !== first && third !== second && decoder.bit(2 * PATTERNS + pattern)) {
        found = third;
      }
      if (found < 0) {
        let node = 1;
        for (let digit = 0; digit < depth; digit += 1) node = 2 * node + decoder.bit(TREES + 2 ** depth + node);
        found = node - 2 ** depth;
        if (found >= count) throw new RangeError("names a cluster that is not there");
      }
      labels[face] = found;
    }
    [this.#previous, this.#count] = [labels, count];
    return labels;
  }
}
