import { niftiHeader, type Samples, type SamplesOf } from "@/format/nifti";
import { readArchive } from "./archive";
import { type Dataset, type DicomFile, type Element, parseDicom, PIXELS, text } from "./dicomFile";

type Triple = [number, number, number];

/** One picture of a series: a file, or a frame of one. */
interface Slice {
  series: string;
  rows: number;
  columns: number;
  /** Of the middle of the first pixel, LPS mm. */
  position: Triple;
  /** In which direction columns and rows count up. */
  along: Triple;
  down: Triple;
  /** Between rows, and between columns, in mm. */
  spacing: [number, number];
  slope: number;
  intercept: number;
  array: SamplesOf;
  /** Its pixels, out of the way of this thread's memory; null where the file is cut off. */
  pixels: Blob | null;
}

const MOST_VOXELS = 2 ** 28;
/** Whether numbers lie in memory with their lowest byte first. */
const LITTLE = new Uint8Array(Uint16Array.of(1).buffer)[0] === 1;

/** A DICOM series, a zip of its files or one file with many frames, as a NIfTI file; throws a sentence. */
export async function dicomAsNifti(file: Blob, format: string): Promise<Blob> {
  const slices: Slice[] = [];
  if (format === "dicom-zip") {
    for (const entry of await readArchive(file)) {
      if (entry.size > 0) slices.push(...slicesOf(await parseDicom(await entry.read())));
    }
  } else slices.push(...slicesOf(await parseDicom(await file.arrayBuffer())));
  return stack(slices);
}

/**
 * The pictures of one series by where they lie along their normal (PS3.3 section C.7.6.2): what comes twice at one
 * place, as in a series over time, is shown once.
 */
async function stack(all: readonly Slice[]): Promise<Blob> {
  const series = all[0]?.series;
  const [first, ...others] = all.filter((slice) => slice.series === series);
  if (!first) throw new Error("There is no picture in this DICOM series.");
  const { rows, columns, along, down, spacing } = first;
  if (others.some((slice) => slice.rows !== rows || slice.columns !== columns)) {
    throw new Error("The slices of this DICOM series differ in size.");
  }
  const normal = cross(along, down);
  const placed = [first, ...others]
    .map((slice) => ({ slice, depth: dot(slice.position, normal) }))
    .sort((one, other) => one.depth - other.depth);
  const near = Math.min(...spacing) * 1e-3;
  const slices = placed
    .filter(({ depth }, k) => k === 0 || depth - (placed[k - 1]?.depth ?? 0) > near)
    .map(({ slice }) => slice);
  const count = slices.length;
  if (columns * rows * count > MOST_VOXELS) throw new Error("The series is too large to be drawn in the browser.");
  const even = slices.every(
    ({ slope, intercept, array }) => slope === first.slope && intercept === first.intercept && array === first.array,
  );
  const parts: Blob[] = [];
  for (const { pixels, array, slope, intercept } of slices) {
    if (!pixels) throw new Error("A slice of this series is cut off.");
    const scaled = async () =>
      Float32Array.from(new array(await pixels.arrayBuffer()), (own) => slope * own + intercept);
    parts.push(even ? pixels : new Blob([await scaled()]));
  }
  const [low, high] = [slices[0]?.position ?? [0, 0, 0], slices[count - 1]?.position ?? [0, 0, 0]];
  const affine = ([-1, -1, 1] as const).flatMap((sign, axis) => [
    sign * (along[axis] ?? 0) * spacing[1],
    sign * (down[axis] ?? 0) * spacing[0],
    sign * (count > 1 ? ((high[axis] ?? 0) - (low[axis] ?? 0)) / (count - 1) : (normal[axis] ?? 0)),
    sign * (low[axis] ?? 0),
  ]);
  const [slope, inter] = even ? [first.slope, first.intercept] : [1, 0];
  const array = even ? first.array : Float32Array;
  const header = niftiHeader({ shape: [columns, rows, count], affine, slope, inter, array, little: LITTLE });
  return new Blob([header, ...parts]);
}

function slicesOf(file: DicomFile | null): Slice[] {
  const pixels = file?.elements.get(PIXELS);
  if (!file || !pixels) return []; // a report, or the folder's index
  const tell = (set: Dataset | undefined, tag: number) => decimals(file, set?.get(tag));
  const own = (tag: number) => {
    const element = file.elements.get(tag);
    return element && element.length >= 2 ? file.view.getUint16(element.at, file.little) : undefined;
  };
  const [rows = 0, columns = 0, bits = 16] = [own(0x00280010), own(0x00280011), own(0x00280100)];
  if ((own(0x00280002) ?? 1) !== 1) throw new Error("This DICOM series is in color, which is not drawn here.");
  if (bits !== 8 && bits !== 16) throw new Error(`Pixels of ${bits} bits are not drawn here.`);
  const group = (frame: number, tag: number): Dataset | undefined => {
    const each = file.elements.get(0x52009230)?.items?.[frame];
    return each?.get(tag)?.items?.[0] ?? file.elements.get(0x52009229)?.items?.[0]?.get(tag)?.items?.[0];
  };
  const size = (rows * columns * bits) / 8;
  const stored = own(0x00280101) ?? bits;
  const signed = own(0x00280103) === 1;
  const array: SamplesOf = bits > 8 ? (signed ? Int16Array : Uint16Array) : signed ? Int8Array : Uint8Array;
  const frames = Math.max(1, Math.min(tell(file.elements, 0x00280008)[0] ?? 1, Math.floor(pixels.length / size)));
  return Array.from({ length: frames }, (_, frame): Slice => {
    const find = (within: number, tag: number) => {
      const told = tell(group(frame, within), tag);
      return told.length > 0 ? told : tell(file.elements, tag);
    };
    const [ax = 1, ay = 0, az = 0, dx = 0, dy = 1, dz = 0] = find(0x00209116, 0x00200037);
    const [x = 0, y = 0, z = frame] = find(0x00209113, 0x00200032);
    const [between = 1, across = 1] = find(0x00289110, 0x00280030);
    const uid = file.elements.get(0x0020000e);
    return {
      series: uid ? text(file.view, uid.at, uid.length) : "",
      rows,
      columns,
      position: [x, y, z],
      along: [ax, ay, az],
      down: [dx, dy, dz],
      spacing: [between, across],
      slope: find(0x00289145, 0x00281053)[0] ?? 1,
      intercept: find(0x00289145, 0x00281052)[0] ?? 0,
      array,
      pixels: pixelsAt(file, pixels.at + frame * size, new array(rows * columns), stored, signed),
    };
  });
}

/** The pixels that begin somewhere, each without the bits above it that are none of its own; null where they end early. */
function pixelsAt(
  { view, little }: DicomFile,
  at: number,
  into: Samples,
  stored: number,
  signed: boolean,
): Blob | null {
  if (at + into.byteLength > view.byteLength) return null;
  const shift = 32 - stored;
  const wide = into.BYTES_PER_ELEMENT === 2;
  for (let k = 0; k < into.length; k += 1) {
    const raw = (wide ? view.getUint16(at + 2 * k, little) : view.getUint8(at + k)) << shift;
    into[k] = signed ? raw >> shift : raw >>> shift;
  }
  return new Blob([into as Samples & ArrayBufferView<ArrayBuffer>]);
}

/** Numbers that are written as text, with backslashes between. */
function decimals({ view }: DicomFile, element: Element | undefined): number[] {
  return element && element.length > 0 ? text(view, element.at, element.length).split("\\").map(Number) : [];
}

function dot(a: Triple, b: Triple): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Triple, b: Triple): Triple {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
