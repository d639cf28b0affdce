import type { SurfaceMesh } from "@/viewers/surface/readSurface";
import { type ArchiveEntry, isMeshName, readArchive } from "./archive";
import { readMesh } from "./mesh";

/** A mesh whose vertices move. */
export interface Sequence {
  frames: number;
  faces: Uint32Array;
  /** x, y and z of each vertex in a frame. */
  positions: (frame: number) => Promise<Float32Array>;
}

/** Frames that stay in memory once they were read. */
const KEPT = 64;

/** Open a sequence: an npz with `vertices` and `faces`, or a zip with a mesh for each frame. Throws a sentence. */
export async function openSequence(file: Blob): Promise<Sequence> {
  const entries = await readArchive(file);
  const named = (name: string) => entries.find((entry) => entry.name === name);
  const [vertices, faces] = [named("vertices.npy"), named("faces.npy")];
  return vertices && faces ? ofArrays(vertices, faces) : ofMeshes(entries);
}

async function ofArrays(vertices: ArchiveEntry, faces: ArchiveEntry): Promise<Sequence> {
  const corners = await readNpy(faces);
  const points = await readNpy(vertices);
  const [frames = 0, count = 0] = points.shape;
  return {
    frames,
    faces: Uint32Array.from({ length: corners.size }, (_, index) => corners.at(index)),
    positions: (frame) =>
      Promise.resolve(Float32Array.from({ length: 3 * count }, (_, index) => points.at(3 * count * frame + index))),
  };
}

async function ofMeshes(entries: readonly ArchiveEntry[]): Promise<Sequence> {
  const frames = entries
    .filter(({ name, size }) => isMeshName(name) && size > 0)
    .sort((one, other) => one.name.localeCompare(other.name, undefined, { numeric: true }));
  const first = frames[0];
  if (!first) throw new Error("The archive holds no mesh that is read here.");
  const { faces, positions } = readMesh(await first.read(), first.name);
  const known = new Map<number, Promise<Float32Array>>([[0, Promise.resolve(positions)]]);
  const read = async (index: number) => {
    const entry = frames[index];
    const mesh: SurfaceMesh = entry ? readMesh(await entry.read(), entry.name) : { positions, faces };
    const same = mesh.positions.length === positions.length && mesh.faces.every((corner, at) => corner === faces[at]);
    if (!same || mesh.faces.length !== faces.length) {
      throw new Error(`${entry?.name} has other vertices or faces than the first.`);
    }
    return mesh.positions;
  };
  return {
    frames: frames.length,
    faces,
    positions: (index) => {
      const found = known.get(index) ?? read(index);
      known.set(index, found);
      const oldest = known.keys().next().value;
      if (known.size > KEPT && oldest !== undefined) known.delete(oldest);
      return found;
    },
  };
}

interface Npy {
  shape: number[];
  size: number;
  /** A value by its place in C order. */
  at: (index: number) => number;
}

const GETTERS: Record<string, [number, (view: DataView, at: number, little: boolean) => number]> = {
  f2: [2, (view, at, little) => half(view.getUint16(at, little))],
  f4: [4, (view, at, little) => view.getFloat32(at, little)],
  f8: [8, (view, at, little) => view.getFloat64(at, little)],
  i1: [1, (view, at) => view.getInt8(at)],
  i2: [2, (view, at, little) => view.getInt16(at, little)],
  i4: [4, (view, at, little) => view.getInt32(at, little)],
  i8: [8, (view, at, little) => Number(view.getBigInt64(at, little))],
  u1: [1, (view, at) => view.getUint8(at)],
  u2: [2, (view, at, little) => view.getUint16(at, little)],
  u4: [4, (view, at, little) => view.getUint32(at, little)],
  u8: [8, (view, at, little) => Number(view.getBigUint64(at, little))],
};

/** An array as NumPy saves it (https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html). */
async function readNpy(entry: ArchiveEntry): Promise<Npy> {
  const content = await entry.read();
  const view = new DataView(content);
  const wide = view.getUint8(6) > 1;
  const begin = wide ? 12 : 10;
  const data = begin + (wide ? view.getUint32(8, true) : view.getUint16(8, true));
  const header = new TextDecoder("latin1").decode(new Uint8Array(content, begin, data - begin));
  const [, order, type = ""] = /'descr':\s*'([<>|=])(\w\d)'/.exec(header) ?? [];
  const [, listed] = /'shape':\s*\(([\d, ]*)\)/.exec(header) ?? [];
  const [bytes, get] = GETTERS[type] ?? [0, () => 0];
  const shape = listed
    ?.split(",")
    .filter((part) => part.trim())
    .map(Number);
  const size = shape?.reduce((product, extent) => product * extent, 1) ?? 0;
  if (bytes === 0 || !shape || data + bytes * size > content.byteLength) {
    throw new Error(`The array ${entry.name} cannot be read.`);
  }
  const little = order !== ">";
  const plain = !/'fortran_order':\s*True/.test(header);
  const place = plain ? (index: number) => index : (index: number) => fortran(index, shape);
  return { shape, size, at: (index) => get(view, data + bytes * place(index), little) };
}

/** Where a value lies whose first index grows fastest. */
function fortran(index: number, shape: readonly number[]): number {
  let [place, rest, stride] = [0, index, shape.reduce((product, extent) => product * extent, 1)];
  for (const extent of [...shape].reverse()) {
    stride /= extent;
    place += (rest % extent) * stride;
    rest = Math.floor(rest / extent);
  }
  return place;
}

/** A number of half precision (IEEE 754). */
function half(bits: number): number {
  const [sign, exponent, fraction] = [bits & 0x8000 ? -1 : 1, (bits >> 10) & 31, bits & 1023];
  if (exponent === 31) return fraction ? Number.NaN : sign * Number.POSITIVE_INFINITY;
  return sign * (exponent === 0 ? 2 ** -24 * fraction : 2 ** (exponent - 15) * (1 + fraction / 1024));
}
