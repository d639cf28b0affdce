import { expect, it } from "vitest";
import type { Samples } from "@/format/nifti";
import { Blocks, coarserAffine, stepsFor, type Triple } from "@/viewers/volume/reduce";

/** A volume of no more than `most` voxels that shows the same, if its axes allow. */
function reduced<T extends Samples>(samples: T, extent: Triple, affine: number[][], most: number) {
  const steps = stepsFor(extent, most);
  const blocks = new Blocks(samples.constructor as new (length: number) => T, extent, steps, false);
  const [nx, ny, nz] = extent;
  for (let row = 0; row < ny * nz; row += 1) blocks.add(samples.subarray(row * nx, (row + 1) * nx));
  return { samples: blocks.samples, extent: blocks.extent, affine: coarserAffine(affine, steps) };
}

/** Intensities that are linear in the place: their means are those of the middles. */
function ramp(extent: [number, number, number], affine: number[][]) {
  const [nx, ny, nz] = extent;
  const at = (i: number, j: number, k: number) => [0, 1, 2].map((r) => mm(affine, r, [i, j, k]));
  const samples = new Float64Array(nx * ny * nz);
  for (let k = 0, to = 0; k < nz; k += 1)
    for (let j = 0; j < ny; j += 1)
      for (let i = 0; i < nx; i += 1, to += 1) {
        const [x = 0, y = 0, z = 0] = at(i, j, k);
        samples[to] = x + 10 * y + 100 * z;
      }
  return { samples, extent, affine };
}

const mm = (affine: number[][], row: number, index: number[]) =>
  [...index, 1].reduce((sum, value, axis) => sum + (affine[row]?.[axis] ?? 0) * value, 0);

it("halves the long axes, and leaves everything where it is in space", () => {
  const affine = [
    [-0.4, 0.02, 0, 60],
    [0.02, 0.4, 0.1, -70],
    [0, -0.1, 2.5, 3],
    [0, 0, 0, 1],
  ];
  const whole = ramp([301, 260, 3], affine);
  const small = reduced(whole.samples, whole.extent, affine, 150 * 130 * 3);
  expect(small.extent).toEqual([150, 130, 3]);
  const told = ramp(small.extent, small.affine);
  let largest = 0;
  small.samples.forEach((value, at) => (largest = Math.max(largest, Math.abs(value - (told.samples[at] ?? NaN)))));
  expect(largest).toBeLessThan(1e-9);
});

it("keeps whole numbers whole", () => {
  const samples = new Uint8Array(258).fill(7);
  samples[0] = 10;
  const identity = [0, 1, 2, 3].map((row) => [0, 1, 2, 3].map((column) => Number(row === column)));
  const { samples: means } = reduced(samples, [258, 1, 1], identity, 129);
  expect(means).toBeInstanceOf(Uint8Array);
  expect([...means.subarray(0, 2)]).toEqual([9, 7]);
});

it("halves long axes alone until few enough voxels are left, and leaves small volumes alone", () => {
  const steps = (most: number) => stepsFor([600, 200, 2], most);
  expect(steps(240_000)).toEqual([1, 1, 1]);
  expect(steps(70_000)).toEqual([2, 2, 1]);
  expect(steps(40_000)).toEqual([4, 2, 1]);
  expect(steps(10)).toEqual([8, 2, 1]);
  expect(stepsFor([512, 512, 512], 2 ** 24)).toEqual([2, 2, 2]);
  expect(stepsFor([512, 512, 40], 2 ** 20)).toEqual([4, 4, 1]);
  expect(stepsFor([64, 64, 64], 10)).toEqual([1, 1, 1]);
});
