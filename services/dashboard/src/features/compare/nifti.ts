/** A volume of whole numbers as a NIfTI-1 file holds it. */
export interface LabelVolume {
  shape: [number, number, number];
  /** From voxel indices to RAS mm: the upper three rows, row by row. */
  affine: number[];
  values: ArrayLike<number>;
  slope: number;
  inter: number;
}

type Reader = new (buffer: ArrayBuffer) => ArrayLike<number>;

const TYPES: Record<number, { bytes: number; array: Reader; get: keyof DataView }> = {
  2: { bytes: 1, array: Uint8Array, get: "getUint8" },
  4: { bytes: 2, array: Int16Array, get: "getInt16" },
  8: { bytes: 4, array: Int32Array, get: "getInt32" },
  16: { bytes: 4, array: Float32Array, get: "getFloat32" },
  64: { bytes: 8, array: Float64Array, get: "getFloat64" },
  256: { bytes: 1, array: Int8Array, get: "getInt8" },
  512: { bytes: 2, array: Uint16Array, get: "getUint16" },
  768: { bytes: 4, array: Uint32Array, get: "getUint32" },
};
const MAX_VOXELS = 1 << 28;

/** Undo gzip where there is any. */
export async function inflate(content: ArrayBuffer): Promise<ArrayBuffer> {
  const start = new Uint8Array(content, 0, Math.min(2, content.byteLength));
  if (start[0] !== 0x1f || start[1] !== 0x8b) return content;
  const stream = new Blob([content]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** Read a NIfTI-1 volume, of several the first where `several` are allowed; throws a sentence where it cannot be read. */
export function readNifti(content: ArrayBuffer, several = false): LabelVolume {
  if (content.byteLength < 352) throw new Error("The file is no NIfTI volume: it is too short.");
  const view = new DataView(content);
  const little = view.getInt32(0, true) === 348;
  if (!little && view.getInt32(0, false) !== 348) throw new Error("The file is no NIfTI-1 volume.");
  const short = (at: number) => view.getInt16(at, little);
  const float = (at: number) => view.getFloat32(at, little);
  const size = (axis: number) => (axis <= short(40) ? short(40 + 2 * axis) : 1);
  if (!several && (size(4) > 1 || size(5) > 1)) throw new Error("The file holds several volumes; a mask is one.");
  const shape: [number, number, number] = [size(1), size(2), size(3)];
  const voxels = shape[0] * shape[1] * shape[2];
  const type = TYPES[short(70)];
  if (!type) throw new Error(`The voxels are of a type that is not read here (NIfTI type ${short(70)}).`);
  const offset = Math.round(float(108));
  if (shape.some((extent) => extent < 1) || voxels > MAX_VOXELS || offset + voxels * type.bytes > content.byteLength) {
    throw new Error("The file ends before its voxels do.");
  }
  let values: ArrayLike<number>;
  if (little) {
    values = new type.array(content.slice(offset, offset + voxels * type.bytes));
  } else {
    const get = (view[type.get] as (at: number, little: boolean) => number).bind(view);
    values = Float64Array.from({ length: voxels }, (_, index) => get(offset + index * type.bytes, false));
  }
  const slope = float(112);
  const scaled = Number.isFinite(slope) && slope !== 0;
  return { shape, affine: affineOf(float, short), values, slope: scaled ? slope : 1, inter: scaled ? float(116) : 0 };
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
