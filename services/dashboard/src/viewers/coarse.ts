import type { SurfaceMesh } from "./surface/readSurface";

/** A mesh with fewer faces than another: each of its vertices stands for those of the other in one cell of a grid. */
export interface Coarse {
  /** Three vertices of each face. */
  faces: Uint32Array;
  /** x, y and z of each vertex, from those of the vertices that it stands for: their mean. */
  gather(positions: Float32Array): Float32Array;
}

/** Of a vertex that has no place, as one with a coordinate that is no number. */
const NOWHERE = 0xffff_ffff;

/** Faces that are left of as much surface as a cell's side has: a surface crosses 1.5 cells there, each with two. */
const FIRST = 3;
/** Cells along the longest side at the most. */
const FINEST = 2 ** 20;

/**
 * Make a mesh coarser by clustering its vertices on a grid (Rossignac and Borrel, Multi-resolution 3D approximations for
 * rendering complex scenes, 1993), until no more than `most` faces are left; null where it has no more. O(vertices +
 * faces) for each of a few tries. Faces keep their orientation, and what is closed stays closed.
 */
export function coarsen({ positions, faces }: SurfaceMesh, most: number): Coarse | null {
  if (faces.length <= 3 * most) return null;
  const { low, longest } = boxOf(positions);
  let size = Math.max(Math.sqrt((FIRST * areaOf(positions, faces)) / most), longest / FINEST) || 1;
  for (;;) {
    const clusters = cluster(positions, low, size, most);
    const kept = clusters && facesBetween(clusters.of, faces);
    if (clusters && kept && kept.length <= 3 * most) return { faces: kept, gather: gathering(clusters) };
    size *= kept ? Math.max(1.1, Math.sqrt(kept.length / (3 * most))) : 2;
  }
}

/** The lowest x, y and z, and the longest side of the box around all vertices. */
function boxOf(positions: Float32Array): { low: [number, number, number]; longest: number } {
  const low: [number, number, number] = [Infinity, Infinity, Infinity];
  const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < positions.length; at += 3) {
    for (const axis of [0, 1, 2] as const) {
      const value = positions[at + axis] as number;
      if (!Number.isFinite(value)) continue;
      if (value < low[axis]) low[axis] = value;
      if (value > high[axis]) high[axis] = value;
    }
  }
  return { low, longest: Math.max(0, ...high.map((value, axis) => value - (low[axis] ?? 0))) };
}

/** Of all faces whose corners have a place. */
function areaOf(positions: Float32Array, faces: Uint32Array): number {
  let sum = 0;
  const at = (corner: number, axis: number) => positions[3 * (faces[corner] as number) + axis] as number;
  for (let f = 0; f < faces.length; f += 3) {
    const [x, y, z] = [at(f, 0), at(f, 1), at(f, 2)];
    const [ux, uy, uz] = [at(f + 1, 0) - x, at(f + 1, 1) - y, at(f + 1, 2) - z];
    const [vx, vy, vz] = [at(f + 2, 0) - x, at(f + 2, 1) - y, at(f + 2, 2) - z];
    const [nx, ny, nz] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const area = Math.sqrt(nx * nx + ny * ny + nz * nz) / 2;
    if (Number.isFinite(area)) sum += area;
  }
  return sum;
}

interface Clusters {
  /** The cluster of each vertex. */
  of: Uint32Array;
  count: number;
}

/** Vertices by the cell of a grid in which they lie; null where there would be more than `most`. */
function cluster(positions: Float32Array, low: readonly number[], size: number, most: number): Clusters | null {
  const [lx = 0, ly = 0, lz = 0] = low;
  const of = new Uint32Array(positions.length / 3);
  // A table with open addresses: the cell of each cluster, three numbers, and the cluster at each place, from one.
  const places = 2 ** Math.ceil(Math.log2(2 * most + 2));
  const table = new Uint32Array(places);
  const cells = new Float64Array(3 * most);
  let count = 0;
  for (let v = 0; v < of.length; v += 1) {
    const x = Math.floor(((positions[3 * v] as number) - lx) / size);
    const y = Math.floor(((positions[3 * v + 1] as number) - ly) / size);
    const z = Math.floor(((positions[3 * v + 2] as number) - lz) / size);
    if (!Number.isFinite(x + y + z)) {
      of[v] = NOWHERE;
      continue;
    }
    let place = mix(x, y, z) & (places - 1);
    for (;;) {
      const there = table[place] as number;
      if (there === 0) {
        if (count === most) return null;
        cells.set([x, y, z], 3 * count);
        table[place] = count + 1;
        of[v] = count;
        count += 1;
        break;
      }
      const at = 3 * (there - 1);
      if (cells[at] === x && cells[at + 1] === y && cells[at + 2] === z) {
        of[v] = there - 1;
        break;
      }
      place = (place + 1) & (places - 1);
    }
  }
  return { of, count };
}

/** A hash of three whole numbers: each bit of each changes about half of the lower bits. */
function mix(x: number, y: number, z: number): number {
  let hash = Math.imul(x, 0x9e3779b1) ^ Math.imul(y, 0x85ebca6b) ^ Math.imul(z, 0xc2b2ae35);
  hash = Math.imul(hash ^ (hash >>> 15), 0x2c1b3c6d);
  return hash ^ (hash >>> 13);
}

/** The faces whose corners lie in three clusters. */
function facesBetween(of: Uint32Array, faces: Uint32Array): Uint32Array {
  const kept = new Uint32Array(faces.length);
  let length = 0;
  for (let f = 0; f < faces.length; f += 3) {
    const a = of[faces[f] as number] ?? NOWHERE;
    const b = of[faces[f + 1] as number] ?? NOWHERE;
    const c = of[faces[f + 2] as number] ?? NOWHERE;
    if (a === b || b === c || c === a || a === NOWHERE || b === NOWHERE || c === NOWHERE) continue;
    kept[length] = a;
    kept[length + 1] = b;
    kept[length + 2] = c;
    length += 3;
  }
  return kept.slice(0, length);
}

function gathering({ of, count }: Clusters): Coarse["gather"] {
  return (positions) => {
    const sums = new Float64Array(3 * count);
    const members = new Uint32Array(count);
    for (let v = 0; v < of.length; v += 1) {
      const to = of[v] as number;
      if (to === NOWHERE) continue;
      members[to] = (members[to] as number) + 1;
      for (let axis = 0; axis < 3; axis += 1) {
        sums[3 * to + axis] = (sums[3 * to + axis] as number) + (positions[3 * v + axis] as number);
      }
    }
    return Float32Array.from(sums, (sum, at) => sum / (members[Math.floor(at / 3)] as number));
  };
}
