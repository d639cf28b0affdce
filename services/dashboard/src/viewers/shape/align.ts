import type { ShapeModel } from "./model";
import { partCenters, surfaceOf, type Vector } from "./surface";

interface Pair {
  query: number;
  found: number;
  weight: number;
}

type Quaternion = [number, number, number, number];

/** Fewer pairs say nothing about how a shape lies. */
const FEWEST = 4;
/** A smaller turn is not worth leaving the upright pose. */
const SMALLEST = Math.PI / 5;
/** Nor is one after which the parts still lie apart: the mean square, of before and of their distance from the middle. */
const [NEARER, NEAR] = [0.5, 0.2];

/**
 * A found shape beside the one that it was found by: seen from the same side, and turned so that matched parts lie in
 * the same place where a file has it in another pose, and the turn brings them much nearer together.
 */
export function beside(found: ShapeModel, query: ShapeModel, level: number, matches: readonly Pair[]): ShapeModel {
  const [from, to] = [centers(found, level), centers(query, level)];
  const pairs = matches.flatMap((pair): [Vector, Vector, number][] => {
    const [here, there] = [from[pair.found], to[pair.query]];
    return here && there ? [[here, there, pair.weight]] : [];
  });
  const turn = pairs.length < FEWEST ? null : turnOnto(pairs);
  return { ...(turn ? turned(found, turn) : found), towards: query.towards };
}

/**
 * The turn about the origin that brings weighted points nearest to their partners, as a unit quaternion: the
 * eigenvector of the largest eigenvalue of a symmetric matrix (B. Horn, Closed-form solution of absolute orientation
 * using unit quaternions, J. Opt. Soc. Am. A 4(4), 1987), by power iteration. Null where the points lie well as they are.
 */
export function turnOnto(pairs: readonly (readonly [Vector, Vector, number])[]): Quaternion | null {
  const sums = new Float64Array(9);
  let [sizes, before] = [0, 0];
  for (const [from, to, weight] of pairs) {
    for (let i = 0; i < 3; i += 1) {
      for (let j = 0; j < 3; j += 1) sums[3 * i + j] = at(sums, 3 * i + j) + weight * at(from, i) * at(to, j);
      sizes += weight * (at(from, i) ** 2 + at(to, i) ** 2);
      before += weight * (at(from, i) - at(to, i)) ** 2;
    }
  }
  const [xx = 0, xy = 0, xz = 0, yx = 0, yy = 0, yz = 0, zx = 0, zy = 0, zz = 0] = sums;
  const matrix = [
    [xx + yy + zz, yz - zy, zx - xz, xy - yx],
    [yz - zy, xx - yy - zz, xy + yx, zx + xz],
    [zx - xz, xy + yx, yy - xx - zz, yz + zy],
    [xy - yx, zx + xz, yz + zy, zz - xx - yy],
  ];
  const times = (q: Quaternion) =>
    matrix.map((row) => row.reduce((sum, value, k) => sum + value * at(q, k), 0)) as Quaternion;
  const shift = Math.hypot(...matrix.flat()); // makes the largest eigenvalue the one of largest modulus
  let turn: Quaternion = [0.9, 0.3, 0.2, 0.1];
  for (let step = 0; step < 300; step += 1) {
    const next = times(turn).map((value, k) => value + shift * at(turn, k));
    const length = Math.hypot(...next) || 1;
    turn = next.map((value) => value / length) as Quaternion;
  }
  const largest = times(turn).reduce((sum, value, k) => sum + value * at(turn, k), 0);
  const angle = 2 * Math.acos(Math.min(1, Math.abs(turn[0])));
  return angle > SMALLEST && sizes - 2 * largest < Math.min(NEARER * before, NEAR * sizes) ? turn : null;
}

function turned(model: ShapeModel, [w, x, y, z]: Quaternion): ShapeModel {
  const { positions, faces } = model.surface;
  const matrix: readonly Vector[] = [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ];
  const moved = new Float32Array(positions.length);
  for (let v = 0; v < positions.length; v += 3) {
    const point = positions.subarray(v, v + 3);
    matrix.forEach((row, k) => {
      moved[v + k] = row[0] * at(point, 0) + row[1] * at(point, 1) + row[2] * at(point, 2);
    });
  }
  const surface = surfaceOf({ positions: moved, faces });
  return {
    ...model,
    surface,
    centers: (level, count) => {
      const parts = model.parts(level);
      return parts ? partCenters(surface, parts, count) : model.centers(level, count);
    },
  };
}

function centers(model: ShapeModel, level: number): (Vector | null)[] {
  const parts = model.parts(level);
  return parts ? model.centers(level, parts.reduce((most, part) => Math.max(most, part), 0) + 1) : [];
}

function at(values: ArrayLike<number>, index: number): number {
  return values[index] as number;
}
