import type { Samples } from "@/format/nifti";

/** One number for each axis, x first. */
export type Triple = [number, number, number];

/** An axis of fewer voxels is not halved. */
const FEW = 128;

/** A block of labels is drawn where at least this share of it is labeled, so that what is thin is not lost. */
const LABELED = 0.25;

/** How many voxels become one along each axis: long axes are halved until there are no more than `most` in all. */
export function stepsFor(extent: Triple, most: number): Triple {
  const steps: Triple = [1, 1, 1];
  const left = (axis: number) => Math.floor((extent[axis] ?? 1) / (steps[axis] ?? 1));
  while (left(0) * left(1) * left(2) > most && Math.max(left(0), left(1), left(2)) > FEW) {
    for (const axis of [0, 1, 2] as const) if (left(axis) > FEW) steps[axis] *= 2;
  }
  return steps;
}

/** From voxels to mm after blocks of `steps` voxels became one: its middle lies between theirs. */
export function coarserAffine(affine: readonly (readonly number[])[], steps: Triple): number[][] {
  const moved = affine.slice(0, 3).map((row) => {
    const shift = steps.reduce((sum, step, axis) => sum + (row[axis] ?? 0) * ((step - 1) / 2), row[3] ?? 0);
    return [...steps.map((step, axis) => (row[axis] ?? 0) * step), shift];
  });
  return [...moved, [0, 0, 0, 1]];
}

/**
 * Makes blocks of voxels one, of a volume that comes row by row: intensities their mean, labels their largest where
 * enough of the block is labeled. What does not fill a block at the end of an axis is left out.
 */
export class Blocks<T extends Samples> {
  readonly samples: T;
  readonly extent: Triple;
  readonly #steps: Triple;
  readonly #rows: number;
  readonly #labels: boolean;
  readonly #whole: boolean;
  /** Of the layer of blocks that is being filled: sums of intensities, or counts of labeled voxels. */
  readonly #sums: Float64Array;
  #row = 0;

  constructor(make: new (length: number) => T, extent: Triple, steps: Triple, labels: boolean) {
    this.#steps = steps;
    this.#rows = extent[1];
    this.#labels = labels;
    this.extent = extent.map((length, axis) => Math.floor(length / (steps[axis] ?? 1))) as Triple;
    const [mx, my, mz] = this.extent;
    this.samples = new make(mx * my * mz);
    this.#whole = !(this.samples instanceof Float32Array || this.samples instanceof Float64Array);
    this.#sums = new Float64Array(mx * my);
  }

  /** The next row of voxels along x, those that come before it having been added. */
  add(row: ArrayLike<number>): void {
    const [sx, sy, sz] = this.#steps;
    const [mx, my, mz] = this.extent;
    const y = Math.floor((this.#row % this.#rows) / sy);
    const layer = Math.floor(this.#row / this.#rows);
    const z = Math.floor(layer / sz);
    this.#row += 1;
    if (z >= mz) return;
    if (y < my) this.#gather(row, y * mx, (z * my + y) * mx);
    if (this.#row % this.#rows === 0 && layer % sz === sz - 1) this.#finish(z * mx * my, sx * sy * sz);
  }

  #gather(row: ArrayLike<number>, to: number, at: number): void {
    const [sx] = this.#steps;
    const [mx] = this.extent;
    const sums = this.#sums;
    for (let x = 0, from = 0; x < mx; x += 1) {
      let sum = 0;
      if (this.#labels) {
        let largest = this.samples[at + x] as number;
        for (let dx = 0; dx < sx; dx += 1, from += 1) {
          const label = row[from] as number;
          if (label > 0) sum += 1;
          if (label > largest) largest = label;
        }
        this.samples[at + x] = largest;
      } else {
        for (let dx = 0; dx < sx; dx += 1, from += 1) sum += row[from] as number;
      }
      sums[to + x] = (sums[to + x] as number) + sum;
    }
  }

  #finish(at: number, count: number): void {
    const { samples } = this;
    const sums = this.#sums;
    for (let i = 0; i < sums.length; i += 1) {
      const mean = (sums[i] as number) / count;
      if (!this.#labels) samples[at + i] = this.#whole ? Math.round(mean) : mean;
      else if (mean < LABELED) samples[at + i] = 0;
    }
    sums.fill(0);
  }
}
