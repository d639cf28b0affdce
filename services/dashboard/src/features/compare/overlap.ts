import type { LabelVolume } from "@/format/nifti";

/** How often each value of one volume meets each value of another, voxel by voxel on the grid of the first. */
export interface Overlap {
  /** Values that occur in the first and in the second, ascending. */
  ours: number[];
  theirs: number[];
  /** Voxels with `ours[i]` and `theirs[j]`, at i · theirs.length + j. */
  counts: number[];
  voxelVolume: number;
  /** Whether the second lies on another grid, and was asked for the nearest voxel. */
  resampled: boolean;
}

const MAX_VALUES = 64;

export function overlap(ours: LabelVolume, theirs: LabelVolume): Overlap {
  const toTheirs = compose(inverse(theirs.affine), ours.affine);
  const [nx, ny, nz] = ours.shape;
  const [mx, my, mz] = theirs.shape;
  const rows = new Map<number, Map<number, number>>();
  const [a = 0, b = 0, c = 0, d = 0, e = 0, f = 0, g = 0, h = 0, i = 0, j = 0, k = 0, l = 0] = toTheirs;
  let index = 0;
  for (let z = 0; z < nz; z += 1) {
    for (let y = 0; y < ny; y += 1) {
      for (let x = 0; x < nx; x += 1) {
        const mine = Math.round((ours.values[index] ?? 0) * ours.slope + ours.inter);
        index += 1;
        const u = Math.round(a * x + b * y + c * z + d);
        const v = Math.round(e * x + f * y + g * z + h);
        const w = Math.round(i * x + j * y + k * z + l);
        const inside = u >= 0 && v >= 0 && w >= 0 && u < mx && v < my && w < mz;
        const other = inside
          ? Math.round((theirs.values[u + mx * (v + my * w)] ?? 0) * theirs.slope + theirs.inter)
          : 0;
        let row = rows.get(mine);
        if (!row) rows.set(mine, (row = new Map<number, number>()));
        row.set(other, (row.get(other) ?? 0) + 1);
        if (row.size > MAX_VALUES) throw new Error("The reference is no mask: it holds too many different values.");
      }
    }
  }
  const ascending = (values: Iterable<number>) => [...new Set(values)].sort((one, two) => one - two);
  const mine = ascending(rows.keys());
  const other = ascending([...rows.values()].flatMap((row) => [...row.keys()]));
  if (mine.length > MAX_VALUES || other.length > MAX_VALUES) {
    throw new Error("The reference is no mask: it holds too many different values.");
  }
  return {
    ours: mine,
    theirs: other,
    counts: mine.flatMap((one) => other.map((two) => rows.get(one)?.get(two) ?? 0)),
    voxelVolume: Math.abs(determinant(ours.affine)),
    resampled:
      mx !== nx || my !== ny || mz !== nz || toTheirs.some((entry, at) => Math.abs(entry - (IDENTITY[at] ?? 0)) > 1e-3),
  };
}

export interface Agreement {
  iou: number;
  dice: number;
  /** In voxels: in both, in the first alone, in the second alone. */
  both: number;
  added: number;
  missed: number;
}

/** Compare the union of some values with the union of some others. */
export function agreement(of: Overlap, ours: ReadonlySet<number>, theirs: ReadonlySet<number>): Agreement {
  let both = 0;
  let added = 0;
  let missed = 0;
  of.ours.forEach((mine, row) =>
    of.theirs.forEach((other, column) => {
      const voxels = of.counts[row * of.theirs.length + column] ?? 0;
      if (ours.has(mine) && theirs.has(other)) both += voxels;
      else if (ours.has(mine)) added += voxels;
      else if (theirs.has(other)) missed += voxels;
    }),
  );
  const union = both + added + missed;
  return {
    iou: union > 0 ? both / union : 1, // two that are empty agree
    dice: union > 0 ? (2 * both) / (2 * both + added + missed) : 1,
    both,
    added,
    missed,
  };
}

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

function determinant(m: readonly number[]): number {
  const [a = 0, b = 0, c = 0, , e = 0, f = 0, g = 0, , i = 0, j = 0, k = 0] = m;
  return a * (f * k - g * j) - b * (e * k - g * i) + c * (e * j - f * i);
}

/** Of the upper three rows of an affine map, row by row. */
export function inverse(m: readonly number[]): number[] {
  const [a = 0, b = 0, c = 0, x = 0, e = 0, f = 0, g = 0, y = 0, i = 0, j = 0, k = 0, z = 0] = m;
  const det = determinant(m);
  if (!Number.isFinite(det) || Math.abs(det) < 1e-12) throw new Error("The reference's header gives its axes no room.");
  const r = [
    f * k - g * j,
    c * j - b * k,
    b * g - c * f,
    g * i - e * k,
    a * k - c * i,
    c * e - a * g,
    e * j - f * i,
    b * i - a * j,
    a * f - b * e,
  ].map((cofactor) => cofactor / det);
  const [r0 = 0, r1 = 0, r2 = 0, r3 = 0, r4 = 0, r5 = 0, r6 = 0, r7 = 0, r8 = 0] = r;
  return [
    ...[r0, r1, r2, -(r0 * x + r1 * y + r2 * z)],
    ...[r3, r4, r5, -(r3 * x + r4 * y + r5 * z)],
    ...[r6, r7, r8, -(r6 * x + r7 * y + r8 * z)],
  ];
}

/** One after the other: first `second`, then `first`. */
function compose(first: readonly number[], second: readonly number[]): number[] {
  return [0, 1, 2].flatMap((row) =>
    [0, 1, 2, 3].map((column) => {
      let sum = column === 3 ? (first[row * 4 + 3] ?? 0) : 0;
      for (let at = 0; at < 3; at += 1) sum += (first[row * 4 + at] ?? 0) * (second[at * 4 + column] ?? 0);
      return sum;
    }),
  );
}
