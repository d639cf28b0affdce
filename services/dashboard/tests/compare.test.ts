import { gzipSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { inflate, type LabelVolume, readNifti } from "@/format/nifti";
import { agreement, overlap } from "@/features/compare/overlap";

const PLAIN = [2, 0, 0, -10, 0, 2, 0, -20, 0, 0, 3, 5];

interface Made {
  shape?: [number, number, number];
  values?: number[];
  affine?: number[];
  little?: boolean;
  type?: number;
  slope?: number;
}

/** A NIfTI-1 file of small numbers. */
function nifti({
  shape = [2, 2, 1],
  values = [0, 1, 2, 3],
  affine = PLAIN,
  little = true,
  type = 4,
  slope = 0,
}: Made = {}) {
  const bytes = type === 2 ? 1 : type === 16 ? 4 : 2;
  const view = new DataView(new ArrayBuffer(352 + values.length * bytes));
  view.setInt32(0, 348, little);
  [3, ...shape, 1, 1, 1, 1].forEach((size, index) => view.setInt16(40 + 2 * index, size, little));
  view.setInt16(70, type, little);
  view.setFloat32(108, 352, little);
  view.setFloat32(112, slope, little);
  view.setInt16(254, 1, little);
  affine.forEach((entry, index) => view.setFloat32(280 + 4 * index, entry, little));
  values.forEach((value, index) => {
    if (type === 2) view.setUint8(352 + index, value);
    else if (type === 16) view.setFloat32(352 + 4 * index, value, little);
    else view.setInt16(352 + 2 * index, value, little);
  });
  return view.buffer;
}

const volume = (made: Made): LabelVolume => readNifti(nifti(made));

describe("readNifti", () => {
  it.each([2, 4, 16])("reads type %i in both byte orders", (type) => {
    for (const little of [true, false]) {
      const { shape, values, affine } = volume({ type, little });
      expect([shape, Array.from(values), affine]).toEqual([[2, 2, 1], [0, 1, 2, 3], PLAIN]);
    }
  });

  it("takes the quaternion where there is no matrix", () => {
    const view = new DataView(nifti());
    view.setInt16(254, 0, true);
    view.setInt16(252, 1, true);
    [1, 2, 2, 3].forEach((step, index) => view.setFloat32(76 + 4 * index, step, true));
    view.setFloat32(264, 1, true); // half a turn about z
    [-10, -20, 5].forEach((shift, index) => view.setFloat32(268 + 4 * index, shift, true));
    expect(readNifti(view.buffer).affine.map((entry) => entry + 0)).toEqual([-2, 0, 0, -10, 0, -2, 0, -20, 0, 0, 3, 5]);
  });

  it("undoes gzip, and leaves alone what is none", async () => {
    const plain = nifti();
    const packed = gzipSync(new Uint8Array(plain));
    const inflated = await inflate(new Uint8Array(packed).buffer);
    expect(new Uint8Array(inflated)).toEqual(new Uint8Array(plain));
    expect(await inflate(plain)).toBe(plain);
  });

  it.each([
    ["too short", new ArrayBuffer(10), /too short/],
    ["of zeros", new ArrayBuffer(400), /no NIfTI-1/],
    ["cut off", nifti().slice(0, 355), /ends before/],
    ["too large a promise", nifti({ shape: [30000, 30000, 30000] }), /ends before/],
    ["of colors", nifti({ type: 128 }), /type 128/],
  ])("refuses a file that is %s", (_, content, says) => expect(() => readNifti(content)).toThrow(says));
});

describe("overlap", () => {
  it("counts who meets whom, and gives any union's IoU and Dice", () => {
    const ours = volume({ values: [0, 1, 1, 2] });
    const theirs = volume({ values: [0, 4, 0, 4] });
    const met = overlap(ours, theirs);
    expect(met).toMatchObject({ ours: [0, 1, 2], theirs: [0, 4], voxelVolume: 12, resampled: false });
    expect(met.counts).toEqual([1, 0, 1, 1, 0, 1]);
    expect(agreement(met, new Set([1, 2]), new Set([4]))).toEqual({
      iou: 2 / 3,
      dice: 0.8,
      both: 2,
      added: 1,
      missed: 0,
    });
    expect(agreement(met, new Set([1]), new Set([4]))).toMatchObject({ iou: 1 / 3, both: 1, added: 1, missed: 1 });
    expect(agreement(met, new Set([7]), new Set([9])).iou).toBe(1);
  });

  it("finds the same place however the grid of the other is turned", () => {
    const ours = volume({ shape: [3, 2, 1], values: [0, 1, 2, 3, 4, 5] });
    // The same six voxels, first axis backwards.
    const flipped = volume({
      shape: [3, 2, 1],
      values: [2, 1, 0, 5, 4, 3],
      affine: [-2, 0, 0, -6, 0, 2, 0, -20, 0, 0, 3, 5],
    });
    const met = overlap(ours, flipped);
    expect(met.resampled).toBe(true);
    for (const value of met.ours) expect(agreement(met, new Set([value]), new Set([value])).iou).toBe(1);
  });

  it("reads scaled values, and counts what lies outside as nothing", () => {
    const ours = volume({ values: [1, 1, 1, 1] });
    const beside = volume({ values: [1, 1, 1, 1], affine: [2, 0, 0, -8, 0, 2, 0, -20, 0, 0, 3, 5] });
    expect(agreement(overlap(ours, beside), new Set([1]), new Set([1])).both).toBe(2);
    expect(overlap(ours, volume({ values: [1, 1, 0, 0], slope: 5 })).theirs).toEqual([0, 5]);
  });

  it("refuses what is no mask", () => {
    const values = Array.from({ length: 100 }, (_, index) => index);
    const image = volume({ shape: [10, 10, 1], values });
    expect(() => overlap(volume({ shape: [10, 10, 1], values: values.map(() => 0) }), image)).toThrow(/no mask/);
  });
});
