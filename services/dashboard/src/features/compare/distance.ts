import type { LabelVolume } from "@/format/nifti";
import { inverse } from "./overlap";

/** The faces between voxels that are inside and such that are not, as boxes without thickness, by cells of a grid. */
interface Border {
  /** Edge of a cell in mm, and how many there are along each axis. */
  cell: number;
  counts: [number, number, number];
  low: [number, number, number];
  /** Of the faces in each cell: where they begin in `faces`. */
  begin: Uint32Array;
  /** Middle of each face (mm along the voxels' axes), and the axis that it is perpendicular to. */
  faces: Float32Array;
  axes: Uint8Array;
}

type Triple = [number, number, number];

/**
 * How far points (RAS mm, three numbers each) lie from the border of a mask, in mm: positive outside of it, negative
 * inside. The border is that of the voxels, exactly; `counted` are the values that make up the mask.
 */
export function signedDistances(points: Float32Array, mask: LabelVolume, counted: ReadonlySet<number>): Float32Array {
  const spacing = spacingOf(mask.affine);
  const inside = insideOf(mask, counted);
  const border = borderOf(inside, mask.shape, spacing);
  const toVoxel = inverse(mask.affine);
  const found = new Float32Array(points.length / 3);
  const [nx, ny, nz] = mask.shape;
  for (let index = 0; index < found.length; index += 1) {
    const [u, v, w] = [0, 1, 2].map((row) => {
      let sum = toVoxel[4 * row + 3] ?? 0;
      for (let axis = 0; axis < 3; axis += 1) sum += (toVoxel[4 * row + axis] ?? 0) * (points[3 * index + axis] ?? 0);
      return sum;
    }) as Triple;
    const [i, j, k] = [Math.round(u), Math.round(v), Math.round(w)];
    const there = i >= 0 && j >= 0 && k >= 0 && i < nx && j < ny && k < nz && inside[i + nx * (j + ny * k)] === 1;
    const distance = nearest([u * spacing[0], v * spacing[1], w * spacing[2]], border, spacing);
    found[index] = there ? -distance : distance;
  }
  return found;
}

function spacingOf(affine: readonly number[]): Triple {
  const column = (axis: number) => [0, 4, 8].map((row) => affine[row + axis] ?? 0);
  const dot = (one: number[], two: number[]) => one.reduce((sum, value, at) => sum + value * (two[at] ?? 0), 0);
  const spacing = [0, 1, 2].map((axis) => Math.sqrt(dot(column(axis), column(axis)))) as Triple;
  for (const [one, two] of [
    [0, 1],
    [0, 2],
    [1, 2],
  ] as const) {
    if (Math.abs(dot(column(one), column(two))) > 1e-3 * spacing[one] * spacing[two]) {
      throw new Error("The mask's axes are not perpendicular to each other: distances to it cannot be told.");
    }
  }
  return spacing;
}

function insideOf({ values, slope, inter, shape }: LabelVolume, counted: ReadonlySet<number>): Uint8Array {
  const inside = new Uint8Array(shape[0] * shape[1] * shape[2]);
  for (let index = 0; index < inside.length; index += 1) {
    if (counted.has(Math.round((values[index] ?? 0) * slope + inter))) inside[index] = 1;
  }
  return inside;
}

function borderOf(inside: Uint8Array, [nx, ny, nz]: Triple, spacing: Triple): Border {
  const middles: number[] = [];
  const normals: number[] = [];
  const steps = [1, nx, nx * ny];
  const size = [nx, ny, nz];
  for (let k = 0, index = 0; k < nz; k += 1) {
    for (let j = 0; j < ny; j += 1) {
      for (let i = 0; i < nx; i += 1, index += 1) {
        if (!inside[index]) continue;
        const at = [i, j, k];
        for (let axis = 0; axis < 3; axis += 1) {
          const place = at[axis] ?? 0;
          const step = steps[axis] ?? 0;
          const ends = [
            place > 0 && inside[index - step] === 1,
            place + 1 < (size[axis] ?? 0) && inside[index + step] === 1,
          ];
          ends.forEach((goesOn, side) => {
            if (goesOn) return;
            for (let other = 0; other < 3; other += 1) {
              middles.push(((at[other] ?? 0) + (other === axis ? side - 0.5 : 0)) * (spacing[other] ?? 1));
            }
            normals.push(axis);
          });
        }
      }
    }
  }
  if (normals.length === 0) throw new Error("The mask is empty: there is nothing to measure distances to.");
  return sorted(middles, normals, 4 * Math.max(...spacing));
}

function sorted(middles: readonly number[], normals: readonly number[], cell: number): Border {
  const low: Triple = [Infinity, Infinity, Infinity];
  const high: Triple = [-Infinity, -Infinity, -Infinity];
  middles.forEach((value, at) => {
    const axis = (at % 3) as 0 | 1 | 2;
    low[axis] = Math.min(low[axis], value);
    high[axis] = Math.max(high[axis], value);
  });
  const counts = low.map((begin, axis) => Math.floor(((high[axis] ?? 0) - begin) / cell) + 1) as Triple;
  const cellOf = (face: number) => {
    const [x, y, z] = [0, 1, 2].map((axis) => Math.floor(((middles[3 * face + axis] ?? 0) - (low[axis] ?? 0)) / cell));
    return (x ?? 0) + counts[0] * ((y ?? 0) + counts[1] * (z ?? 0));
  };
  const begin = new Uint32Array(counts[0] * counts[1] * counts[2] + 1);
  normals.forEach((_, face) => (begin[cellOf(face) + 1] = (begin[cellOf(face) + 1] ?? 0) + 1));
  for (let at = 1; at < begin.length; at += 1) begin[at] = (begin[at] ?? 0) + (begin[at - 1] ?? 0);
  const next = begin.slice();
  const faces = new Float32Array(middles.length);
  const axes = new Uint8Array(normals.length);
  normals.forEach((axis, face) => {
    const at = next[cellOf(face)] ?? 0;
    next[cellOf(face)] = at + 1;
    for (let one = 0; one < 3; one += 1) faces[3 * at + one] = middles[3 * face + one] ?? 0;
    axes[at] = axis;
  });
  return { cell, counts, low, begin, faces, axes };
}

/** Cells are looked through from the point outwards, until none that is left can hold anything nearer. */
function nearest(point: Triple, border: Border, spacing: Triple): number {
  const { cell, counts, low, begin } = border;
  const home = point.map((value, axis) => Math.floor((value - (low[axis] ?? 0)) / cell)) as Triple;
  const reach = Math.max(...spacing) / 2;
  // How many rings lie between the point and the nearest cell, and where the last cell is.
  const away = Math.max(0, ...home.map((at, axis) => Math.max(-at, at - (counts[axis] ?? 1) + 1)));
  const last = Math.max(...home.map((at, axis) => Math.max(Math.abs(at), Math.abs((counts[axis] ?? 1) - 1 - at))));
  let best = Infinity;
  for (let ring = away; ring <= last; ring += 1) {
    if (best <= Math.max(0, (ring - 1) * cell - reach) ** 2) break;
    const [x0, y0, z0] = home.map((at) => Math.max(at - ring, 0)) as Triple;
    const [x1, y1, z1] = home.map((at, axis) => Math.min(at + ring, (counts[axis] ?? 1) - 1)) as Triple;
    for (let z = z0; z <= z1; z += 1) {
      for (let y = y0; y <= y1; y += 1) {
        const whole = Math.abs(z - home[2]) === ring || Math.abs(y - home[1]) === ring;
        for (let x = x0; x <= x1; x += 1) {
          if (!whole && Math.abs(x - home[0]) !== ring) {
            // Inside of the ring: on to its far side.
            x = Math.max(x, Math.min(home[0] + ring, x1 + 1) - 1);
            continue;
          }
          const at = x + counts[0] * (y + counts[1] * z);
          for (let face = begin[at] ?? 0; face < (begin[at + 1] ?? 0); face += 1) {
            best = Math.min(best, squaredDistance(point, border, face, spacing));
          }
        }
      }
    }
  }
  return Math.sqrt(best);
}

function squaredDistance(point: Triple, { faces, axes }: Border, face: number, spacing: Triple): number {
  let sum = 0;
  for (let axis = 0; axis < 3; axis += 1) {
    const half = axes[face] === axis ? 0 : (spacing[axis] ?? 0) / 2;
    const beyond = Math.max(0, Math.abs((point[axis] ?? 0) - (faces[3 * face + axis] ?? 0)) - half);
    sum += beyond * beyond;
  }
  return sum;
}
