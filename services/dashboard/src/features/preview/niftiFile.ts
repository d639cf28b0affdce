import type { LabelVolume } from "@/features/compare/nifti";

const HEADER = 352;
/** NIfTI's numbers for types, and their bits. */
const CODES: readonly [new (length: number) => ArrayBufferView, number, number][] = [
  [Uint8Array, 2, 8],
  [Int16Array, 4, 16],
  [Int32Array, 8, 32],
  [Float32Array, 16, 32],
  [Float64Array, 64, 64],
  [Int8Array, 256, 8],
  [Uint16Array, 512, 16],
  [Uint32Array, 768, 32],
];

/** A volume as a NIfTI-1 file (https://nifti.nimh.nih.gov/nifti-1): what every viewer reads. */
export function niftiFile({ shape, affine, values, slope, inter }: LabelVolume): Blob {
  const [, code, bits] = CODES.find(([type]) => values instanceof type) ?? [Float32Array, 16, 32];
  const data = ArrayBuffer.isView(values) ? (values as Float32Array<ArrayBuffer>) : Float32Array.from(values);
  const view = new DataView(new ArrayBuffer(HEADER));
  const short = (at: number, value: number) => view.setInt16(at, value, true);
  const float = (at: number, value: number) => view.setFloat32(at, value, true);
  view.setInt32(0, 348, true);
  short(40, 3);
  for (let axis = 1; axis <= 7; axis += 1) short(40 + 2 * axis, shape[axis - 1] ?? 1);
  short(70, code);
  short(72, bits);
  float(76, 1);
  for (let axis = 0; axis < 3; axis += 1) {
    float(80 + 4 * axis, Math.hypot(...[0, 1, 2].map((row) => affine[4 * row + axis] ?? 0)));
  }
  float(108, HEADER);
  float(112, slope);
  float(116, inter);
  view.setUint8(123, 2); // millimetres
  short(254, 1); // the affine below is that of the scanner
  affine.forEach((value, index) => float(280 + 4 * index, value));
  new Uint8Array(view.buffer).set(new TextEncoder().encode("n+1"), 344);
  return new Blob([view, data], { type: "application/octet-stream" });
}
