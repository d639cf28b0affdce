import { expect, it } from "vitest";
import { readNifti } from "@/format/nifti";
import { NiftiStream } from "@/viewers/volume/niftiStream";

interface Made {
  extent: [number, number, number];
  little?: boolean;
  /** Bytes between the header and the voxels. */
  gap?: number;
  volumes?: number;
  value: (x: number, y: number, z: number, volume: number) => number;
}

/** A NIfTI-1 file of signed 16-bit numbers. */
function made({ extent, little = true, gap = 0, volumes = 1, value }: Made): Uint8Array {
  const [nx, ny, nz] = extent;
  const offset = 352 + gap;
  const bytes = new Uint8Array(offset + 2 * nx * ny * nz * volumes);
  const view = new DataView(bytes.buffer);
  view.setInt32(0, 348, little);
  [volumes > 1 ? 4 : 3, nx, ny, nz, volumes, 1, 1, 1].forEach((size, at) => view.setInt16(40 + 2 * at, size, little));
  view.setInt16(70, 4, little);
  view.setInt16(72, 16, little);
  [1, 0.5, 0.5, 3].forEach((length, at) => view.setFloat32(76 + 4 * at, length, little));
  view.setFloat32(108, offset, little);
  view.setInt16(254, 1, little);
  [0.5, 0, 0, -9, 0, 0.5, 0, 7, 0, 0, 3, 1].forEach((entry, at) => view.setFloat32(280 + 4 * at, entry, little));
  bytes.set([110, 43, 49, 0], 344);
  let at = offset;
  for (let v = 0; v < volumes; v += 1)
    for (let z = 0; z < nz; z += 1)
      for (let y = 0; y < ny; y += 1)
        for (let x = 0; x < nx; x += 1, at += 2) view.setInt16(at, value(x, y, z, v), little);
  return bytes;
}

function streamed(file: Uint8Array, most: number, labels: boolean, piece: number) {
  const stream = new NiftiStream(most, labels);
  let more = true;
  let taken = 0;
  for (; more && taken < file.length; taken += piece) more = stream.push(file.slice(taken, taken + piece));
  return { ...stream.finish(), more, taken };
}

for (const little of [true, false]) {
  for (const piece of [1_000_000, 777, 351]) {
    it(`makes a large volume coarser, ${little ? "little" : "big"} end first, in pieces of ${piece} bytes`, () => {
      const file = made({ extent: [260, 131, 3], little, gap: 48, value: (x, y, z) => 2 * x - 4 * y + 100 * z });
      const { content, steps } = streamed(file, 130 * 65 * 3, false, piece);
      expect(steps).toEqual([2, 2, 1]);
      const told = readNifti(content);
      expect(told.shape).toEqual([130, 65, 3]);
      const expected = [];
      for (let z = 0; z < 3; z += 1)
        for (let y = 0; y < 65; y += 1)
          for (let x = 0; x < 130; x += 1) expected.push(2 * (2 * x + 0.5) - 4 * (2 * y + 0.5) + 100 * z);
      expect([...(told.values as Int16Array)]).toEqual(expected);
      // It still says where the file's own voxels are: whoever draws it knows the steps.
      expect(told.affine).toEqual(readNifti(file.slice().buffer).affine);
    });
  }
}

it("keeps thin labels, and drops what hardly reaches into a block", () => {
  const label = (x: number, y: number) => (x === 10 ? 3 : x >= 101 && y === 0 ? 1 : 0);
  const file = made({ extent: [260, 260, 1], value: label });
  const { content } = streamed(file, 130 * 130, true, 4096);
  const { values } = readNifti(content);
  for (let y = 0; y < 130; y += 1) {
    expect(values[130 * y + 5]).toBe(3); // half of each block
    expect(values[130 * y + 4]).toBe(0);
  }
  expect(values[49]).toBe(0);
  expect(values[50]).toBe(1); // a quarter of its block
});

it("takes the first of several volumes, and needs no more of the file", () => {
  const file = made({ extent: [260, 130, 2], volumes: 3, value: (_x, _y, _z, volume) => 50 + volume });
  const { content, more, taken } = streamed(file, 20_000, false, 10_000);
  expect(more).toBe(false);
  expect(taken).toBeLessThan(file.length / 2);
  const { shape, values } = readNifti(content);
  expect(shape).toEqual([130, 65, 2]);
  expect(new Set(values as Int16Array)).toEqual(new Set([50]));
});

it("keeps small volumes and other files as they are", () => {
  const small = made({ extent: [20, 10, 4], value: (x) => x });
  const other = new Uint8Array(5000).map((_, at) => at % 251);
  const nowhere = made({ extent: [260, 131, 3], value: (x) => x });
  nowhere[254] = 0; // it does not say where it is
  for (const file of [small, other, nowhere, other.slice(0, 10)]) {
    const { content, steps } = streamed(file, 8000, false, 1000);
    expect(steps).toEqual([1, 1, 1]);
    expect(Buffer.compare(Buffer.from(content), Buffer.from(file))).toBe(0);
  }
});

it("says where a file ends too early", () => {
  const file = made({ extent: [260, 131, 3], value: (x) => x });
  expect(() => streamed(file.slice(0, file.length - 100), 20_000, false, 5000)).toThrow("ends before");
});
