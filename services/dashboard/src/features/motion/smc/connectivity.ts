import { CorruptMotion } from "./container";
import { bits, RangeDecoder } from "./rangeCoder";

/** Slots of section 3 of api_schema/smc.md, in their order. */
const FACE = 0;
const KIND = FACE + 64;
const SEED = KIND + 4 * 64;
const NEXT = SEED + 8;
const SIGN = NEXT + 8;
const DELTA = SIGN + 8;
const AGO = DELTA + 3 * 64;
const SLOTS = AGO + 64;

interface HalfEdge {
  from: number;
  to: number;
  /** The third corner of its face. */
  corner: number;
  waits: boolean;
}

/** Decode the faces (m · 3 vertices), each begun with its smallest vertex, and ascending. */
export function decodeFaces(payload: Uint8Array, vertices: number, count: number): Uint32Array {
  const decoder = new RangeDecoder(payload, SLOTS);
  const met: number[] = [];
  const known = new Uint8Array(vertices);
  const degrees = new Int32Array(vertices);
  // only vertices that have faces have lists
  const leaving: HalfEdge[][] = [];
  const entering: HalfEdge[][] = [];
  const queue: HalfEdge[] = [];
  let front = 0;
  let last = -1;
  const losses = [0, 0, 0];

  const seen = (): number => {
    const vertex = met[met.length - 1 - decoder.number(AGO)];
    if (vertex === undefined) throw new CorruptMotion("CONN", "leads to vertices that are not there");
    return vertex;
  };
  const fresh = (one: number, two: number): number => {
    const references = [last, one, two];
    const r = losses.indexOf(Math.min(...losses));
    let vertex = last + 1;
    if (!decoder.bit(NEXT)) {
      const sign = decoder.bit(SIGN + r) ? -1 : 1;
      vertex = (references[r] ?? 0) + sign * decoder.number(DELTA + 64 * r);
    }
    if (vertex < 0 || vertex >= vertices || known[vertex]) {
      throw new CorruptMotion("CONN", "leads to vertices that are not there");
    }
    references.forEach((reference, k) => {
      const loss = losses[k] ?? 0;
      losses[k] = loss + (((bits(Math.abs(vertex - reference)) << 8) - loss) >> 4);
    });
    known[vertex] = 1;
    met.push(vertex);
    last = vertex;
    return vertex;
  };

  const faces: [number, number, number][] = [];
  const add = (a: number, b: number, c: number) => {
    faces.push([a, b, c]);
    for (const corner of [a, b, c]) degrees[corner] = (degrees[corner] ?? 0) + 1;
    for (const [from, to, corner] of [
      [a, b, c],
      [b, c, a],
      [c, a, b],
    ] as const) {
      if (from === to) continue;
      const across = latest(leaving[to], (edge) => edge.to === from);
      if (across) {
        across.waits = false;
        remove(leaving[across.from], across);
        remove(entering[across.to], across);
        continue;
      }
      const edge = { from, to, corner, waits: true };
      (leaving[from] ??= []).push(edge);
      (entering[to] ??= []).push(edge);
      queue.push(edge);
    }
  };

  while (faces.length < count) {
    const edge = queue[front];
    if (!edge) {
      const corners: number[] = [];
      for (let i = 0; i < 3; i += 1) {
        const isNew = decoder.bit(SEED + i);
        corners.push(isNew ? fresh(corners[0] ?? last, corners[1] ?? last) : seen());
      }
      const [a = 0, b = 0, c = 0] = corners;
      add(a, b, c);
      continue;
    }
    front += 1;
    if (!edge.waits) continue;
    const { from: a, to: b, corner: o } = edge;
    const q = 8 * Math.min(degrees[a] ?? 0, 7) + Math.min(degrees[b] ?? 0, 7);
    if (!decoder.bit(FACE + q)) continue;
    const left = latest(entering[a], (other) => other !== edge);
    const right = latest(leaving[b], (other) => other !== edge);
    let c: number;
    if (decoder.bit(KIND + q)) c = fresh(a, o);
    else if (left && decoder.bit(KIND + 64 + q)) c = left.from;
    else if (right && decoder.bit(KIND + 128 + q)) c = right.to;
    else c = seen();
    add(b, a, c);
  }
  return sorted(faces);
}

function latest(edges: readonly HalfEdge[] | undefined, fits: (edge: HalfEdge) => boolean): HalfEdge | undefined {
  return edges?.findLast(fits);
}

function remove(edges: HalfEdge[] | undefined, edge: HalfEdge): void {
  const at = edges?.lastIndexOf(edge) ?? -1;
  if (at >= 0) edges?.splice(at, 1);
}

function sorted(faces: [number, number, number][]): Uint32Array {
  const turned = faces.map(([a, b, c]): [number, number, number] => {
    if (a <= b && a <= c) return [a, b, c];
    return b <= c && b <= a ? [b, c, a] : [c, a, b];
  });
  turned.sort((one, two) => one[0] - two[0] || one[1] - two[1] || one[2] - two[2]);
  return Uint32Array.from(turned.flat());
}
