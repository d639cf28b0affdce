import type { ShapeMesh } from "./glb";

export type Vector = readonly [number, number, number];

/** What follows from a mesh alone: areas, middles, and which faces touch. */
export interface Surface extends ShapeMesh {
  /** Area of each face. */
  areas: Float64Array;
  /** x, y and z of the middle of each face. */
  middles: Float32Array;
  area: number;
}

export function surfaceOf({ positions, faces }: ShapeMesh): Surface {
  const count = faces.length / 3;
  const areas = new Float64Array(count);
  const middles = new Float32Array(3 * count);
  let area = 0;
  for (let f = 0; f < count; f += 1) {
    const [a, b, c] = corners(positions, faces, f);
    const one = minus(b, a);
    const two = minus(c, a);
    const normal = cross(one, two);
    areas[f] = Math.hypot(...normal) / 2;
    area += areas[f] as number;
    for (let k = 0; k < 3; k += 1) {
      middles[3 * f + k] = ((a[k] as number) + (b[k] as number) + (c[k] as number)) / 3;
    }
  }
  return { positions, faces, areas, middles, area };
}

/** How a shape stands: the axes to the right, up and to the front, and, along them, the direction to whoever looks. */
export interface Pose {
  frame: readonly [Vector, Vector, Vector];
  towards: Vector;
}

/** As most files mean it: the y axis up, seen from the front, a little from the left and above. */
export const UPRIGHT: Pose = {
  frame: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  towards: [-0.484, 0.407, 0.775],
};

/** The mesh as it stands: centered, the axes of a frame along x, y and z, and as large as a ball of radius 1. */
export function placed(mesh: ShapeMesh, frame: Pose["frame"]): ShapeMesh {
  const { positions, faces, areas, middles, area } = surfaceOf(mesh);
  const center: [number, number, number] = [0, 0, 0];
  for (let f = 0; f < areas.length; f += 1) {
    for (let k = 0; k < 3; k += 1) {
      center[k] = (center[k] as number) + ((areas[f] as number) * (middles[3 * f + k] as number)) / (area || 1);
    }
  }
  const turned = new Float32Array(positions.length);
  let radius = 0;
  for (let v = 0; v < positions.length / 3; v += 1) {
    const point = minus(vertexOf(positions, v), center);
    radius = Math.max(radius, Math.hypot(...point));
    for (let k = 0; k < 3; k += 1) turned[3 * v + k] = dot(point, frame[k] as Vector);
  }
  if (radius > 0) for (let i = 0; i < turned.length; i += 1) turned[i] = (turned[i] as number) / radius;
  return { positions: turned, faces };
}

/**
 * A normal for each corner of each face: the mean of those faces around its vertex that bend away by less than a crease,
 * so that round is shown round and edges stay sharp.
 */
export function cornerNormals({ positions, faces }: ShapeMesh, crease = 0.7): Float32Array {
  const count = faces.length / 3;
  const weighted = new Float64Array(3 * count);
  const lengths = new Float64Array(count);
  for (let f = 0; f < count; f += 1) {
    const [a, b, c] = corners(positions, faces, f);
    const normal = cross(minus(b, a), minus(c, a));
    weighted.set(normal, 3 * f);
    lengths[f] = Math.hypot(...normal);
  }
  const around = Array.from({ length: positions.length / 3 }, (): number[] => []);
  for (let i = 0; i < faces.length; i += 1) around[faces[i] as number]?.push(Math.floor(i / 3));
  const normals = new Float32Array(9 * count);
  for (let i = 0; i < faces.length; i += 1) {
    const own = vertexOf(weighted, Math.floor(i / 3));
    const ownLength = (lengths[Math.floor(i / 3)] as number) || 1;
    let [x, y, z] = [0, 0, 0];
    for (const f of around[faces[i] as number] ?? []) {
      const other = vertexOf(weighted, f);
      if (dot(own, other) < crease * ownLength * (lengths[f] as number)) continue;
      x += other[0];
      y += other[1];
      z += other[2];
    }
    const length = Math.hypot(x, y, z) || 1;
    normals.set([x / length, y / length, z / length], 3 * i);
  }
  return normals;
}

/** The part of each face: that of most of its corners, of the first where all differ. */
export function faceParts(faces: Uint32Array, labels: ArrayLike<number>): Int32Array {
  const parts = new Int32Array(faces.length / 3);
  for (let f = 0; f < parts.length; f += 1) {
    const [a, b, c] = [0, 1, 2].map((k) => labels[faces[3 * f + k] as number] ?? 0) as [number, number, number];
    parts[f] = b === c ? b : a;
  }
  return parts;
}

/**
 * Where each part is: the middle of its area, moved to the middle of its own nearest face, so that the node of a bent
 * part lies on it; null for a part without faces (too small for the reduced mesh).
 */
export function partCenters(surface: Surface, parts: Int32Array, count: number): (Vector | null)[] {
  const sums = Array.from({ length: count }, () => [0, 0, 0, 0]);
  for (let f = 0; f < parts.length; f += 1) {
    const sum = sums[parts[f] as number];
    if (!sum) continue;
    const weight = surface.areas[f] as number;
    for (let k = 0; k < 3; k += 1) sum[k] = (sum[k] as number) + weight * (surface.middles[3 * f + k] as number);
    sum[3] = (sum[3] as number) + weight;
  }
  const best = new Float64Array(count).fill(Number.POSITIVE_INFINITY);
  const centers = new Array<Vector | null>(count).fill(null);
  for (let f = 0; f < parts.length; f += 1) {
    const part = parts[f] as number;
    const sum = sums[part];
    if (!sum) continue;
    const middle = vertexOf(surface.middles, f);
    const mass = (sum[3] as number) || 1;
    const away = Math.hypot(...[0, 1, 2].map((k) => (middle[k] as number) - (sum[k] as number) / mass));
    if (away < (best[part] as number)) {
      best[part] = away;
      centers[part] = middle;
    }
  }
  return centers;
}

function vertexOf(values: Float32Array | Float64Array, v: number): Vector {
  return [values[3 * v] as number, values[3 * v + 1] as number, values[3 * v + 2] as number];
}

function corners(positions: Float32Array, faces: Uint32Array, f: number): [Vector, Vector, Vector] {
  return [0, 1, 2].map((k) => vertexOf(positions, faces[3 * f + k] as number)) as [Vector, Vector, Vector];
}

function minus(a: Vector, b: Vector): Vector {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
