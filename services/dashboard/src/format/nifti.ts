/** A volume of numbers, as a NIfTI-1 file holds it. */
export interface LabelVolume {
  shape: [number, number, number];
  /** From voxel indices to RAS mm: the upper three rows, row by row. */
  affine: number[];
  values: ArrayLike<number>;
  slope: number;
  inter: number;
}

/** The voxels of a volume in memory. */
export type Samples =
  Uint8Array | Int8Array | Uint16Array | Int16Array | Uint32Array | Int32Array | Float32Array | Float64Array;
export type SamplesOf = new (from: ArrayBuffer | number) => Samples;

/** What the header of a NIfTI-1 file says (https://nifti.nimh.nih.gov/nifti-1). */
export interface NiftiHeader {
  little: boolean;
  /** Voxels along the axes of space. */
  extent: [number, number, number];
  /** Whether it holds several volumes. */
  several: boolean;
  /** NIfTI's number for the type of its voxels, and what holds them here, if anything does. */
  code: number;
  array: SamplesOf | undefined;
  /** Where the voxels begin. */
  offset: number;
  /** Whether header and voxels are one file. */
  single: boolean;
  /** Whether it says where the voxels lie in space. */
  placed: boolean;
  affine: number[];
  slope: number;
  inter: number;
}

const TYPES: Readonly<Record<number, SamplesOf>> = {
  2: Uint8Array,
  4: Int16Array,
  8: Int32Array,
  16: Float32Array,
  64: Float64Array,
  256: Int8Array,
  512: Uint16Array,
  768: Uint32Array,
};
const LENGTH = 348;
/** With the four bytes that say whether something stands between the header and the voxels. */
export const WHOLE_HEADER = 352;
const MAX_VOXELS = 1 << 28;

/** Undo gzip where there is any. */
export async function inflate(content: ArrayBuffer): Promise<ArrayBuffer> {
  const start = new Uint8Array(content, 0, Math.min(2, content.byteLength));
  if (start[0] !== 0x1f || start[1] !== 0x8b) return content;
  const stream = new Blob([content]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** Turn the order of the bytes of each number around. */
export function swap(bytes: Uint8Array, width: number): void {
  if (width > 1) for (let at = 0; at < bytes.length; at += width) bytes.subarray(at, at + width).reverse();
}

/** Read the header at the start of a file; null where there is none. */
export function readHeader(start: Uint8Array): NiftiHeader | null {
  if (start.length < WHOLE_HEADER) return null;
  const view = new DataView(start.buffer, start.byteOffset, start.byteLength);
  const little = view.getInt32(0, true) === LENGTH;
  if (!little && view.getInt32(0, false) !== LENGTH) return null;
  const short = (at: number) => view.getInt16(at, little);
  const float = (at: number) => view.getFloat32(at, little);
  const size = (axis: number) => (axis <= short(40) ? short(40 + 2 * axis) : 1);
  const slope = float(112);
  const scaled = Number.isFinite(slope) && slope !== 0;
  return {
    little,
    extent: [size(1), size(2), size(3)],
    several: size(4) > 1 || size(5) > 1,
    code: short(70),
    array: TYPES[short(70)],
    offset: Math.round(float(108)),
    single: String.fromCharCode(...start.subarray(344, 347)) === "n+1",
    placed: short(252) > 0 || short(254) > 0,
    affine: affineOf(float, short),
    slope: scaled ? slope : 1,
    inter: scaled ? float(116) : 0,
  };
}

/** Read a NIfTI-1 volume, of several the first where `several` are allowed; throws a sentence where it cannot be read. */
export function readNifti(content: ArrayBuffer, several = false): LabelVolume {
  if (content.byteLength < WHOLE_HEADER) throw new Error("The file is no NIfTI volume: it is too short.");
  const header = readHeader(new Uint8Array(content, 0, WHOLE_HEADER));
  if (!header) throw new Error("The file is no NIfTI-1 volume.");
  const { extent, array, offset, affine, slope, inter } = header;
  if (!several && header.several) throw new Error("The file holds several volumes; a mask is one.");
  if (!array) throw new Error(`The voxels are of a type that is not read here (NIfTI type ${header.code}).`);
  const voxels = extent[0] * extent[1] * extent[2];
  const width = new array(1).BYTES_PER_ELEMENT;
  if (extent.some((length) => length < 1) || voxels > MAX_VOXELS || offset + voxels * width > content.byteLength) {
    throw new Error("The file ends before its voxels do.");
  }
  const data = content.slice(offset, offset + voxels * width);
  if (!header.little) swap(new Uint8Array(data), width);
  return { shape: extent, affine, values: new array(data), slope, inter };
}

/** What tells where the voxels of a NIfTI-1 file lie, and what they are. */
export interface NiftiFacts extends Pick<LabelVolume, "shape" | "affine" | "slope" | "inter"> {
  array: SamplesOf;
  little: boolean;
}

/** The header of a NIfTI-1 file, which the voxels follow. */
export function niftiHeader({ shape, affine, slope, inter, array, little }: NiftiFacts): Uint8Array<ArrayBuffer> {
  const [code] = Object.entries(TYPES).find(([, type]) => type === array) ?? [];
  const view = new DataView(new ArrayBuffer(WHOLE_HEADER));
  const short = (at: number, value: number) => view.setInt16(at, value, little);
  const float = (at: number, value: number) => view.setFloat32(at, value, little);
  view.setInt32(0, LENGTH, little);
  short(40, 3);
  for (let axis = 1; axis <= 7; axis += 1) short(40 + 2 * axis, shape[axis - 1] ?? 1);
  short(70, Number(code));
  short(72, 8 * new array(1).BYTES_PER_ELEMENT);
  float(76, 1);
  for (let axis = 0; axis < 3; axis += 1) {
    float(80 + 4 * axis, Math.hypot(...[0, 1, 2].map((row) => affine[4 * row + axis] ?? 0)));
  }
  float(108, WHOLE_HEADER);
  float(112, slope);
  float(116, inter);
  view.setUint8(123, 2); // millimetres
  short(254, 1); // the affine below is that of the scanner
  affine.forEach((value, index) => float(280 + 4 * index, value));
  const bytes = new Uint8Array(view.buffer);
  bytes.set(new TextEncoder().encode("n+1"), 344);
  return bytes;
}

function affineOf(float: (at: number) => number, short: (at: number) => number): number[] {
  if (short(254) > 0) return Array.from({ length: 12 }, (_, index) => float(280 + 4 * index));
  const step = [1, 2, 3].map((axis) => Math.abs(float(76 + 4 * axis)) || 1);
  if (short(252) <= 0) return [step[0] ?? 1, 0, 0, 0, 0, step[1] ?? 1, 0, 0, 0, 0, step[2] ?? 1, 0];
  // A unit quaternion with its real part left out, and the side of the third axis.
  const [b, c, d] = [float(256), float(260), float(264)];
  const a = Math.sqrt(Math.max(0, 1 - b * b - c * c - d * d));
  const [i = 1, j = 1, length = 1] = step;
  const k = float(76) < 0 ? -length : length;
  return [
    (a * a + b * b - c * c - d * d) * i,
    2 * (b * c - a * d) * j,
    2 * (b * d + a * c) * k,
    float(268),
    2 * (b * c + a * d) * i,
    (a * a + c * c - b * b - d * d) * j,
    2 * (c * d - a * b) * k,
    float(272),
    2 * (b * d - a * c) * i,
    2 * (c * d + a * b) * j,
    (a * a + d * d - b * b - c * c) * k,
    float(276),
  ];
}
