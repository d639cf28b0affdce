import { CorruptMotion } from "./container";

/** A face takes part if twice its area is more than this times the square of its longest side. */
const DEGENERATE = 1e-6;
const CLOSE = 1e-11;
const MOST_STEPS = 5000;

/**
 * The system that puts transformed faces together again: "Prediction" in api_schema/smc-gradient.md.
 *
 * It is solved by conjugate gradients, which depend continuously on everything they are given.
 */
export class Gluing {
  readonly #faces: ArrayLike<number>;
  readonly #held: Uint8Array;
  readonly #anchors: Int32Array;
  /** The weighted gradients of the corners' hat functions, 9 for each face; 0 on degenerate ones. */
  readonly #hats: Float64Array;
  /** The matrix by rows, without its diagonal. */
  readonly #starts: Int32Array;
  readonly #columns: Int32Array;
  readonly #values: Float64Array;
  readonly #diagonal: Float64Array;

  constructor(faces: ArrayLike<number>, points: Float64Array, anchors: Int32Array) {
    const n = points.length / 3;
    const count = faces.length / 3;
    this.#faces = faces;
    this.#anchors = anchors;
    this.#held = new Uint8Array(n);
    for (const v of anchors) this.#held[v] = 1;
    const plain = new Float64Array(9 * count);
    const weights = new Float64Array(count);
    let total = 0;
    for (let f = 0; f < count; f += 1) {
      const lengths = hats(points, faces, f, plain);
      weights[f] = lengths;
      total += lengths;
    }
    const mean = total / Math.max(count, 1);
    this.#hats = plain.map((value, at) => (mean > 0 ? (value * (weights[Math.floor(at / 9)] as number)) / mean : 0));
    this.#check(n, weights);

    const rows = Array.from({ length: n }, () => new Map<number, number>());
    this.#diagonal = new Float64Array(n);
    for (let f = 0; f < count; f += 1) {
      if (!((weights[f] as number) > 0)) continue;
      for (let i = 0; i < 3; i += 1) {
        const row = faces[3 * f + i] as number;
        for (let j = 0; j < 3; j += 1) {
          const column = faces[3 * f + j] as number;
          let product = 0;
          for (let k = 0; k < 3; k += 1) {
            product += (this.#hats[9 * f + 3 * i + k] as number) * (plain[9 * f + 3 * j + k] as number);
          }
          if (row === column) this.#diagonal[row] = (this.#diagonal[row] as number) + product;
          else rows[row]?.set(column, (rows[row].get(column) ?? 0) + product);
        }
      }
    }
    this.#starts = new Int32Array(n + 1);
    rows.forEach((row, v) => (this.#starts[v + 1] = (this.#starts[v] as number) + row.size));
    this.#columns = Int32Array.from(rows.flatMap((row) => [...row.keys()]));
    this.#values = Float64Array.from(rows.flatMap((row) => [...row.values()]));
  }

  /** Every part of the mesh, through faces that take part, has an anchor. */
  #check(n: number, weights: Float64Array): void {
    const parts = Int32Array.from({ length: n }, (_, v) => v);
    const root = (v: number): number => {
      let at = v;
      while (parts[at] !== at) {
        const above = parts[parts[at] as number] as number;
        parts[at] = above;
        at = above;
      }
      return at;
    };
    weights.forEach((weight, f) => {
      if (!(weight > 0)) return;
      const [a, b, c] = [0, 1, 2].map((k) => root(this.#faces[3 * f + k] as number)) as [number, number, number];
      parts[b] = a;
      parts[root(c)] = root(a);
    });
    const anchored = new Set([...this.#anchors].map(root));
    for (let v = 0; v < n; v += 1) {
      if (!anchored.has(root(v))) throw new CorruptMotion("GANC", "leaves a part of the mesh without an anchor");
    }
  }

  /**
   * The vertices whose faces come closest to their transformations.
   *
   * `matrices` holds nine numbers for each label, `held` the places of the anchors; `guess` is where to begin, and
   * receives the result.
   */
  solve(labels: Int32Array, matrices: Float64Array, held: Float64Array, guess: Float64Array): void {
    const n = this.#held.length;
    const right = new Float64Array(3 * n);
    for (let f = 0; f < labels.length; f += 1) {
      const matrix = 9 * (labels[f] as number);
      for (let i = 0; i < 3; i += 1) {
        const to = 3 * (this.#faces[3 * f + i] as number);
        for (let row = 0; row < 3; row += 1) {
          let sum = 0;
          for (let k = 0; k < 3; k += 1) {
            sum += (matrices[matrix + 3 * row + k] as number) * (this.#hats[9 * f + 3 * i + k] as number);
          }
          right[to + row] = (right[to + row] as number) + sum;
        }
      }
    }
    this.#anchors.forEach((v, k) => guess.set(held.subarray(3 * k, 3 * k + 3), 3 * v));
    for (let axis = 0; axis < 3; axis += 1) {
      const x = Float64Array.from({ length: n }, (_, v) => guess[3 * v + axis] as number);
      const b = Float64Array.from({ length: n }, (_, v) => right[3 * v + axis] as number);
      this.#descend(x, b);
      x.forEach((value, v) => (guess[3 * v + axis] = value));
    }
  }

  #times(x: Float64Array, into: Float64Array): void {
    for (let v = 0; v < into.length; v += 1) {
      let sum = (this.#diagonal[v] as number) * (x[v] as number);
      for (let e = this.#starts[v] as number; e < (this.#starts[v + 1] as number); e += 1) {
        sum += (this.#values[e] as number) * (x[this.#columns[e] as number] as number);
      }
      into[v] = sum;
    }
  }

  #descend(x: Float64Array, b: Float64Array): void {
    const n = x.length;
    const [image, rest, direction] = [new Float64Array(n), new Float64Array(n), new Float64Array(n)];
    const scaled = (v: number) => {
      const d = this.#diagonal[v] as number;
      return this.#held[v] || !(d > 0) ? 0 : (rest[v] as number) / d;
    };
    this.#times(x, image);
    let power = 0;
    let whole = 0;
    for (let v = 0; v < n; v += 1) {
      if (this.#held[v]) continue;
      rest[v] = (b[v] as number) - (image[v] as number);
      direction[v] = scaled(v);
      power += (rest[v] as number) * (direction[v] as number);
      whole += ((b[v] as number) ** 2 + (image[v] as number) ** 2) / Math.max(this.#diagonal[v] as number, 1e-300);
    }
    const enough = CLOSE * CLOSE * whole;
    for (let step = 0; step < MOST_STEPS && power > enough; step += 1) {
      this.#times(direction, image);
      let slope = 0;
      for (let v = 0; v < n; v += 1) slope += (direction[v] as number) * (this.#held[v] ? 0 : (image[v] as number));
      if (!(slope > 0)) return;
      const length = power / slope;
      let next = 0;
      for (let v = 0; v < n; v += 1) {
        if (this.#held[v]) continue;
        x[v] = (x[v] as number) + length * (direction[v] as number);
        rest[v] = (rest[v] as number) - length * (image[v] as number);
        next += (rest[v] as number) * scaled(v);
      }
      for (let v = 0; v < n; v += 1) direction[v] = scaled(v) + (next / power) * (direction[v] as number);
      power = next;
    }
  }
}

/** Write the gradients of a face's hat functions; returns twice its area, or 0 if it takes no part. */
function hats(points: Float64Array, faces: ArrayLike<number>, f: number, into: Float64Array): number {
  const at = (corner: number, axis: number) => points[3 * (faces[3 * f + corner] as number) + axis] as number;
  const side = (corner: number): Triple => [0, 1, 2].map((axis) => at(corner, axis) - at(0, axis)) as Triple;
  const [a, b] = [side(1), side(2)];
  const c = cross(a, b);
  const area = Math.sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
  const square = ([x, y, z]: Triple) => x * x + y * y + z * z;
  const longest = Math.max(square(a), square(b), square([b[0] - a[0], b[1] - a[1], b[2] - a[2]]));
  if (!(area > DEGENERATE * longest)) return 0;
  const [second, third] = [cross(b, c), cross(c, a)];
  for (let k = 0; k < 3; k += 1) {
    const g2 = (second[k] as number) / (area * area);
    const g3 = (third[k] as number) / (area * area);
    into[9 * f + k] = -g2 - g3;
    into[9 * f + 3 + k] = g2;
    into[9 * f + 6 + k] = g3;
  }
  return area;
}

type Triple = [number, number, number];

function cross(a: Triple, b: Triple): Triple {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
