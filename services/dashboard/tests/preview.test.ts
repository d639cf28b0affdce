import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { describe, expect, it } from "vitest";
import { niftiHeader, readNifti } from "@/format/nifti";
import { readArchive } from "@/features/preview/archive";
import { readMesh } from "@/features/preview/mesh";
import { meshPicture, sliceOf } from "@/features/preview/picture";
import { recognise } from "@/features/preview/recognise";
import { openSequence } from "@/features/preview/sequence";
import { asNifti, readCoarse } from "@/features/preview/volume";
import { zip } from "@/features/uploads/zip";
import { meshFile } from "@/format/meshFiles";

/** The first volume of a file of any format. */
const readVolume = async (file: Blob, format: string) =>
  readNifti(await (await asNifti(file, format)).arrayBuffer(), true);
const text = (content: string) => new TextEncoder().encode(content).buffer;
const TETRAHEDRON = {
  positions: new Float32Array([0, 0, 0, 1.5, 0, 0, 0, 2.25, 0, 0, 0, 1e-7]),
  faces: new Uint32Array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]),
};

describe("meshes", () => {
  const corners = ({ positions, faces }: { positions: Float32Array; faces: Uint32Array }) =>
    [...faces].map((vertex) => [...positions.subarray(3 * vertex, 3 * vertex + 3)]);

  it.each(["stl", "obj"] as const)("come back from the %s that was made of them", async (ending) => {
    const found = readMesh(await meshFile(TETRAHEDRON, ending).arrayBuffer(), ending);
    expect(corners(found)).toEqual(corners(TETRAHEDRON));
  });

  it("have their normals in an STL, outwards as their faces turn", async () => {
    const read = new STLLoader().parse(await meshFile(TETRAHEDRON, "stl").arrayBuffer());
    expect([...read.getAttribute("normal").array.slice(0, 3)]).toEqual([0, 0, -1]);
  });

  it("are read from OFF, polygons in triangles", () => {
    const { positions, faces } = readMesh(
      text("OFF # a square\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"),
      "off",
    );
    expect([positions.length, [...faces]]).toEqual([12, [0, 1, 2, 0, 2, 3]]);
  });

  it("are read from OBJ as programs write it: names, colors, textures, quads, numbers backwards, lines that go on", () => {
    const content =
      "# made by hand\r\nmtllib a.mtl\nv 0 0 0 1 0 0\r\nv 1e0 -0.0 +.0\nv\t1.00000000000000000001 1. 0\n" +
      "v 0 1 -1.5E-3 # a corner\nvt 0.5 0.5\nvn 0 0 1\no it\nusemtl a\ns off\nf 1/1/1 2//1 \\\n3/1 4\nl 1 2\nf -4 -3 -2";
    const { positions, faces } = readMesh(text(content), "obj");
    expect([...positions]).toEqual([...new Float32Array([0, 0, 0, 1, -0, 0, 1, 1, 0, 0, 1, -1.5e-3])]);
    expect([...faces]).toEqual([0, 1, 2, 0, 2, 3, 0, 1, 2]);
  });

  it("have the numbers of a text as near as single precision comes", () => {
    const values = Float32Array.from({ length: 300 }, (_, k) => Math.sin(k) * 10 ** ((k % 60) - 30));
    const lines = Array.from({ length: 100 }, (_, v) => `v ${[...values.subarray(3 * v, 3 * v + 3)].join(" ")}\n`);
    expect(readMesh(text(`${lines.join("")}f 1 2 3\n`), "obj").positions).toEqual(values);
  });

  it("are read from OFF with comments, empty lines and colors", () => {
    const content = "COFF\n\n# counts\n3 1 0\n0 0 0 1 1 1 1\n\n1 0 0 1 1 1 1 # b\n0 1 0 1 1 1 1\n3 0 2 1 0.5 0.5 0.5\n";
    const { positions, faces } = readMesh(text(content), "off");
    expect([[...positions], [...faces]]).toEqual([
      [0, 0, 0, 1, 0, 0, 0, 1, 0],
      [0, 2, 1],
    ]);
  });

  it("are read from STL as text", () => {
    const facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    const { positions, faces } = readMesh(text(`solid it\n${facet}endsolid it\n`), "stl");
    expect([[...positions], [...faces]]).toEqual([
      [0, 0, 0, 1, 0, 0, 0, 1, 0],
      [0, 1, 2],
    ]);
  });

  it("say what is wrong with them", () => {
    expect(() => readMesh(text(""), "obj")).toThrow("no vertices");
    expect(() => readMesh(text("4OFF\n3 1 0\n"), "off")).toThrow("cannot be drawn");
    expect(() => readMesh(text("OFF\n9 9 0\n0 0 0\n"), "off")).toThrow("cannot be drawn");
    expect(() => readMesh(text("glTF"), "glb")).toThrow("no binary glTF");
  });

  it("are drawn with what is nearer in front, in whatever order their faces come", () => {
    const positions = new Float32Array([
      ...[-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], // behind
      ...[-0.3, -0.3, 0.2, 0.3, -0.3, 0.5, 0.3, 0.3, 0.5, -0.3, 0.3, 0.2], // before it, turned from the light
    ]);
    const draw = (faces: number[]) => meshPicture({ positions, faces: new Uint32Array(faces) }, 32).data;
    const [behind, before] = [
      [0, 1, 2, 0, 2, 3],
      [4, 5, 6, 4, 6, 7],
    ] as const;
    const both = draw([...behind, ...before]);
    expect(draw([...before, ...behind])).toEqual(both);
    const middle = 4 * (16 * 32 + 16);
    expect(both[middle]).toBe(draw([...before])[middle]);
    expect(both[middle]).not.toBe(draw([...behind])[middle]);
    expect(both.filter((value, index) => index % 4 === 3 && value > 0).length).toBeGreaterThan(0.5 * 32 * 32);
    expect(both[3]).toBe(0); // a corner of the picture
  });
});

describe("archives and sequences", () => {
  /** An array as NumPy saves it. */
  function npy(descr: string, shape: number[], data: ArrayBufferView<ArrayBuffer>): Blob {
    const header = `{'descr': '${descr}', 'fortran_order': False, 'shape': (${shape.join(", ")}), }`.padEnd(117) + "\n";
    const head = new Uint8Array([0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0, header.length, 0]);
    return new Blob([head, header, data]);
  }

  it("gives the frames of an npz", async () => {
    const file = await zip([
      {
        path: "vertices.npy",
        content: npy(
          "<f8",
          [2, 3, 3],
          Float64Array.from({ length: 18 }, (_, k) => k / 2),
        ),
      },
      { path: "faces.npy", content: npy("<i8", [1, 3], BigInt64Array.of(0n, 2n, 1n)) },
    ]);
    expect(await recognise(file, "x")).toEqual({ kind: "sequence", format: "npz" });
    const { frames, faces, positions } = await openSequence(file);
    expect([frames, [...faces]]).toEqual([2, [0, 2, 1]]);
    expect([...(await positions(1))]).toEqual([4.5, 5, 5.5, 6, 6.5, 7, 7.5, 8, 8.5]);
  });

  it("gives the meshes of a zip in the order of their numbers, and refuses one that differs", async () => {
    const mesh = (x: number, more = "") => new Blob([`v ${x} 0 0\nv 1 0 0\nv 0 1 0\n${more}f 1 2 3\n`]);
    const file = await zip([
      { path: "walk/10.obj", content: mesh(10) },
      { path: "walk/9.obj", content: mesh(9) },
      { path: "walk/11.obj", content: mesh(11, "f 3 2 1\n") },
      { path: "walk/.9.obj", content: new Blob(["litter"]) },
    ]);
    expect(await recognise(file, "x")).toEqual({ kind: "sequence", format: "mesh-zip" });
    const { frames, positions } = await openSequence(file);
    expect([frames, (await positions(0))[0], (await positions(1))[0]]).toEqual([3, 9, 10]);
    await expect(positions(2)).rejects.toThrow("other vertices or faces");
  });

  it("unpacks as far as it is asked to", async () => {
    const content = new Uint8Array(5_000).map((_, index) => index % 251);
    const packed = new Blob([content]).stream().pipeThrough(new CompressionStream("deflate-raw"));
    const deflated = await new Response(packed).arrayBuffer();
    // An archive of one stored file, which is told to be deflated.
    const archive = new Uint8Array(await (await zip([{ path: "a", content: new Blob([deflated]) }])).arrayBuffer());
    const view = new DataView(archive.buffer);
    const directory = view.getUint32(archive.length - 6, true);
    view.setUint16(directory + 10, 8, true);
    view.setUint32(directory + 24, content.length, true);
    const [entry] = await readArchive(new Blob([archive]));
    expect(new Uint8Array((await entry?.read()) ?? new ArrayBuffer())).toEqual(content);
    expect(new Uint8Array((await entry?.read(300)) ?? new ArrayBuffer())).toEqual(content.subarray(0, 300));
    await expect(readArchive(new Blob([archive.subarray(0, -30)]))).rejects.toThrow("cut off");
  });
});

describe("volumes", () => {
  /** Voxels that count up, so that each tells where it lies. */
  const values = Int16Array.from({ length: 60 }, (_, index) => index * 3 - 40);
  const affine = [-0.5, 0, 0, 10, 0, 0.75, 0.1, -20, 0, 0, 2, 30];
  const facts = { shape: [3, 4, 5] as [number, number, number], affine, slope: 2, inter: 1, array: Int16Array };
  const nifti = () => new Blob([niftiHeader({ ...facts, little: true }), values]);

  it("come back from the NIfTI file that was made of them", async () => {
    const found = readNifti(await nifti().arrayBuffer());
    expect([found.shape, found.slope, found.inter]).toEqual([[3, 4, 5], 2, 1]);
    expect([...(found.values as Int16Array)]).toEqual([...values]);
    found.affine.forEach((value, index) => expect(value).toBeCloseTo(affine[index] ?? 0, 6));
    expect(await recognise(nifti(), "x")).toEqual({ kind: "volume", format: "nifti1" });
  });

  it("are read from NRRD, gzipped too, LPS turned into RAS", async () => {
    const head =
      "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 4 5\n" +
      "space directions: (0.5,0,0) (0,-0.75,0) (0,-0.1,2)\nkinds: domain domain domain\nendian: big\n" +
      "encoding: gzip\nspace origin: (-10,20,30)\n\n";
    const big = new DataView(new ArrayBuffer(120));
    values.forEach((value, index) => big.setInt16(2 * index, value, false));
    const packed = new Response(new Blob([big]).stream().pipeThrough(new CompressionStream("gzip")));
    const found = await readVolume(new Blob([head, await packed.arrayBuffer()]), "nrrd");
    expect([...(found.values as Int16Array)]).toEqual([...values]);
    found.affine.forEach((value, index) => expect(value).toBeCloseTo(affine[index] ?? 0, 6));
  });

  it("are read from MetaImage", async () => {
    const head =
      "ObjectType = Image\nNDims = 3\nBinaryDataByteOrderMSB = False\nTransformMatrix = 1 0 0 0 -1 0 0 0 1\n" +
      "Offset = -10 20 30\nElementSpacing = 0.5 0.75 2\nDimSize = 3 4 5\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    const found = await readVolume(new Blob([head, values]), "metaimage");
    expect([...(found.values as Int16Array)]).toEqual([...values]);
    expect(found.affine.map((value) => value + 0)).toEqual([-0.5, 0, 0, 10, 0, 0.75, 0, -20, 0, 0, 2, 30]);
    const short = new Blob([head, values.subarray(1)]);
    await expect(readVolume(short, "metaimage")).rejects.toThrow("ends before");
  });

  it("are read coarser, piece by piece", async () => {
    const shape: [number, number, number] = [256, 4, 3];
    const fine = Int16Array.from({ length: 256 * 12 }, (_, index) => index % 256);
    const file = new Blob([niftiHeader({ ...facts, shape, little: true }), fine]);
    const packed = await new Response(file.stream().pipeThrough(new CompressionStream("gzip"))).blob();
    for (const one of [file, packed]) {
      const found = await readCoarse(one, 2_000);
      expect(found.shape).toEqual([128, 4, 3]);
      expect([...(found.values as Int16Array).subarray(0, 3)]).toEqual([1, 3, 5]); // means, rounded
      // Twice as wide, and their middles half a voxel on.
      const expected = [-1, 0, 0, 9.75, 0, 0.75, 0.1, -20, 0, 0, 2, 30];
      found.affine.forEach((value, index) => expect(value).toBeCloseTo(expected[index] ?? 0, 5));
    }
    expect((await readCoarse(nifti(), 2_000)).shape).toEqual([3, 4, 5]);
    await expect(readCoarse(file.slice(0, -2), 2_000)).rejects.toThrow("ends before");
  });

  it("are seen with the face above and the left on the right, however they are stored", () => {
    // One bright voxel in front, on the patient's left: x is low, y is high.
    const shape: [number, number, number] = [8, 8, 4];
    const spot = (affine: number[]) => {
      const values = new Float32Array(256).fill(1);
      for (let k = 0; k < 4; k += 1) {
        for (let i = 0; i < 8; i += 1) {
          for (let j = 0; j < 8; j += 1) {
            const [x, y] = [0, 1].map((row) =>
              [i, j, k, 1].reduce((sum, v, c) => sum + v * (affine[4 * row + c] ?? 0), 0),
            );
            if ((x ?? 0) < 2 && (y ?? 0) > 5) values[i + 8 * j + 64 * k] = 9;
          }
        }
      }
      return sliceOf({ shape, affine, values, slope: 1, inter: 0 }, 8);
    };
    for (const affine of [
      [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0],
      [-1, 0, 0, 7, 0, -1, 0, 7, 0, 0, 1, 0],
      [0, 1, 0, 0, -1, 0, 0, 7, 0, 0, -1, 3],
    ]) {
      const { width, height, data } = spot(affine);
      const bright = Array.from({ length: width * height }, (_, index) => index).filter(
        (index) => (data[4 * index] ?? 0) > 200,
      );
      expect(bright).toEqual([6, 7, 14, 15]);
    }
  });
});

describe("DICOM", () => {
  /** A slice as a scanner writes it: explicit types, little endian, 12 bits of 16. */
  function slice(z: number, { bits = 12, syntax = "1.2.840.10008.1.2.1", colors = 1, slope = 2 } = {}): Blob {
    const parts: BlobPart[] = [new Uint8Array(128), "DICM"];
    const element = (group: number, number: number, type: string, value: Uint8Array<ArrayBuffer> | string) => {
      const odd = value.length % 2 === 1;
      const head = new DataView(new ArrayBuffer(type === "OW" || type === "SQ" ? 12 : 8));
      head.setUint16(0, group, true);
      head.setUint16(2, number, true);
      head.setUint8(4, type.charCodeAt(0));
      head.setUint8(5, type.charCodeAt(1));
      if (head.byteLength === 12) head.setUint32(8, value.length, true);
      else head.setUint16(6, value.length + Number(odd), true);
      parts.push(head, value, ...(odd ? [" "] : []));
    };
    const short = (value: number) => new Uint8Array(Uint16Array.of(value).buffer);
    element(2, 0x10, "UI", `${syntax}\0`);
    element(8, 0x1140, "SQ", ""); // a sequence without items
    element(0x20, 0x0e, "UI", "1.2.3");
    element(0x20, 0x32, "DS", `-10\\20\\${z}`);
    element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0");
    element(0x28, 2, "US", short(colors));
    element(0x28, 0x10, "US", short(2));
    element(0x28, 0x11, "US", short(3));
    element(0x28, 0x30, "DS", "0.75\\0.5");
    element(0x28, 0x100, "US", short(16));
    element(0x28, 0x101, "US", short(bits));
    element(0x28, 0x103, "US", short(1));
    element(0x28, 0x1052, "DS", "-1024");
    element(0x28, 0x1053, "DS", `${slope}`);
    // What lies above the 12 bits is no part of the value, whose highest bit is its sign.
    element(
      0x7fe0,
      0x10,
      "OW",
      new Uint8Array(Uint16Array.of(1, 2, 3, 4, 5, 0xffff).map((v, k) => (k < 5 ? v + 10 * z : v)).buffer),
    );
    return new Blob(parts);
  }

  it("becomes a volume by where its slices lie", async () => {
    const entries = [5, 1, 3, 3].map((z, index) => ({ path: `${index}`, content: slice(z) }));
    const file = await zip([...entries, { path: "DICOMDIR", content: new Blob(["no slice"]) }]);
    expect(await recognise(file, "x")).toEqual({ kind: "volume", format: "dicom-zip" });
    const found = await readVolume(file, "dicom-zip");
    expect([found.shape, found.slope, found.inter]).toEqual([[3, 2, 3], 2, -1024]);
    expect([...(found.values as Int16Array)]).toEqual([
      11, 12, 13, 14, 15, -1, 31, 32, 33, 34, 35, -1, 51, 52, 53, 54, 55, -1,
    ]);
    expect(found.affine.map((value) => value + 0)).toEqual([-0.5, 0, 0, 10, 0, -0.75, 0, -20, 0, 0, 2, 1]);
  });

  it("becomes a volume of the values that its slices mean, where each is scaled in its own way", async () => {
    const entries = [slice(1), slice(2, { slope: 3 })].map((content, index) => ({ path: `${index}`, content }));
    const found = await readVolume(await zip(entries), "dicom-zip");
    expect([found.slope, found.inter]).toEqual([1, 0]);
    const own = [11, 12, 13, 14, 15, -1];
    const second = [21, 22, 23, 24, 25, -1];
    expect([...(found.values as Float32Array)]).toEqual([
      ...own.map((value) => 2 * value - 1024),
      ...second.map((value) => 3 * value - 1024),
    ]);
  });

  it("says what cannot be read", async () => {
    const jpeg = slice(1, { syntax: "1.2.840.10008.1.2.4.70" });
    await expect(readVolume(jpeg, "dicom")).rejects.toThrow("compressed");
    await expect(readVolume(slice(1, { colors: 3 }), "dicom")).rejects.toThrow("in color");
    await expect(readVolume(slice(1).slice(0, -4), "dicom")).rejects.toThrow("cut off");
    await expect(readVolume(new Blob(["nothing"]), "dicom")).rejects.toThrow("no picture");
  });
});
