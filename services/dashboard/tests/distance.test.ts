import { describe, expect, it } from "vitest";
import { signedDistances } from "@/features/compare/distance";
import type { LabelVolume } from "@/format/nifti";
import { distanceColors, spreadOf } from "@/viewers/surface/scale";

const get = (from: ArrayLike<number>, at: number) => from[at] ?? NaN;
const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

function volume(
  shape: [number, number, number],
  affine: number[],
  value: (x: number, y: number, z: number) => number,
): LabelVolume {
  const values = new Uint8Array(shape[0] * shape[1] * shape[2]);
  let index = 0;
  for (let z = 0; z < shape[2]; z += 1) {
    for (let y = 0; y < shape[1]; y += 1) {
      for (let x = 0; x < shape[0]; x += 1, index += 1) values[index] = value(x, y, z);
    }
  }
  return { shape, affine, values, slope: 1, inter: 0 };
}

/** The voxels 2 to 5 along each axis: from 1.5 to 5.5 where a voxel is 1 mm. */
const inCube = (...place: number[]) => (place.every((at) => at >= 2 && at <= 5) ? 1 : 0);
const cube = volume([9, 9, 9], IDENTITY, inCube);

const at = (mask: LabelVolume, ...points: number[]) => [
  ...signedDistances(new Float32Array(points), mask, new Set([1])),
];

describe("the distance to a mask", () => {
  it("is that to the nearest place of its border", () => {
    expect(at(cube, 1.5, 3, 3)[0]).toBeCloseTo(0);
    expect(at(cube, 0, 3, 3)[0]).toBeCloseTo(1.5);
    expect(at(cube, 7, 8, 3)[0]).toBeCloseTo(Math.hypot(1.5, 2.5));
    expect(at(cube, 7, 8, 9)[0]).toBeCloseTo(Math.hypot(1.5, 2.5, 3.5));
    expect(at(cube, 3.5, 3.5, 3.5)[0]).toBeCloseTo(-2);
    expect(at(cube, 2.2, 3.5, 3.5)[0]).toBeCloseTo(-0.7);
  });

  it("is told far outside of the volume, too", () => {
    expect(at(cube, -200, 3, 3)[0]).toBeCloseTo(201.5, 3);
    expect(at(cube, 100, 200, -300)[0]).toBeCloseTo(Math.hypot(94.5, 194.5, 301.5), 3);
  });

  it("agrees with every face looked at, wherever points lie", () => {
    let state = 1;
    const random = () => (state = (state * 16807) % 2147483647) / 2147483647;
    const shape: [number, number, number] = [17, 13, 11];
    const spacing = [0.7, 1.3, 2.9];
    const affine = [0.7, 0, 0, -5, 0, 1.3, 0, 2, 0, 0, 2.9, 1];
    const mask = volume(shape, affine, () => (random() < 0.2 ? 1 : 0));
    const inside = (x: number, y: number, z: number) =>
      [x, y, z].every((place, axis) => place >= 0 && place < (shape[axis] ?? 0)) &&
      mask.values[x + shape[0] * (y + shape[1] * z)] === 1;
    const points = Float32Array.from({ length: 300 }, (_, index) => (random() - 0.3) * 40 + get([0, 5, 8], index % 3));
    const found = signedDistances(points, mask, new Set([1]));
    const box = (q: number[], place: number[]) =>
      Math.hypot(...q.map((value, axis) => Math.max(0, Math.abs(value - get(place, axis)) - 0.5) * get(spacing, axis)));
    for (let index = 0; index < found.length; index += 1) {
      const q = [0, 1, 2].map(
        (axis) => (get(points, 3 * index + axis) - get(affine, 4 * axis + 3)) / get(spacing, axis),
      );
      const here = inside(Math.round(get(q, 0)), Math.round(get(q, 1)), Math.round(get(q, 2)));
      let expected = Infinity;
      for (let x = -1; x <= 17; x += 1) {
        for (let y = -1; y <= 13; y += 1) {
          // From outside the nearest voxel of the mask counts, from inside the nearest one that is not of it.
          for (let z = -1; z <= 11; z += 1) {
            if (inside(x, y, z) !== here) expected = Math.min(expected, box(q, [x, y, z]));
          }
        }
      }
      expect(found[index]).toBeCloseTo(here ? -expected : expected, 3);
    }
  });

  it("holds for a grid that is turned and flipped", () => {
    // x of the voxels runs towards the back, y to the left, z upwards in steps of 2 mm
    const mask = volume([9, 9, 9], [0, -1, 0, 10, -1, 0, 0, 20, 0, 0, 2, -4], inCube);
    // Its voxels 2 to 5: y from 14.5 to 18.5, x from 4.5 to 8.5, z from -1 to 7.
    expect(at(mask, 10, 16, 3)[0]).toBeCloseTo(1.5);
    expect(at(mask, 6.5, 20, 3)[0]).toBeCloseTo(1.5);
    expect(at(mask, 6.5, 16.5, 8)[0]).toBeCloseTo(1);
    expect(at(mask, 6.5, 16.5, 3)[0]).toBeCloseTo(-2);
  });

  it("reaches to the end of a volume that the mask fills", () => {
    const full = volume([4, 4, 4], IDENTITY, () => 1);
    expect(at(full, 1.5, 1.5, 1.5)[0]).toBeCloseTo(-2);
    expect(at(full, 5, 1.5, 1.5)[0]).toBeCloseTo(1.5);
  });

  it("is refused where there is nothing to measure to", () => {
    expect(() => signedDistances(new Float32Array(3), cube, new Set([7]))).toThrow("empty");
    const sheared = volume([3, 3, 3], [1, 0.3, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0], () => 1);
    expect(() => at(sheared, 0, 0, 0)).toThrow("not perpendicular");
  });
});

describe("the colors of distances", () => {
  it("tell how large they are", () => {
    const spread = spreadOf([Float32Array.of(-1, 1, 2), Float32Array.of(-4)]);
    expect(spread).toEqual({ mean: 2, within95: 4, largest: 4, end: 5 });
    expect(spreadOf([])).toEqual({ mean: 0, within95: 0, largest: 0, end: 0.5 });
  });

  it("are blue inside, white on the border, red outside", () => {
    const colors = [...distanceColors(Float32Array.of(-9, 0, 2), 2)];
    const [inside, border, outside] = [colors.slice(0, 3), colors.slice(3, 6), colors.slice(6)];
    expect(get(inside, 2)).toBeGreaterThan(2 * Math.max(...inside.slice(0, 2)));
    expect(Math.min(...border)).toBeGreaterThan(0.85);
    expect(get(outside, 0)).toBeGreaterThan(2 * Math.max(...outside.slice(1)));
  });
});
