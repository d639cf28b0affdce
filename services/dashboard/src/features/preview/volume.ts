import { inflate, type LabelVolume, readNifti, swap } from "@/format/nifti";
import { readDicom } from "./dicom";

type Samples = new (buffer: ArrayBuffer, at: number, length: number) => ArrayLike<number>;

const TYPES: readonly [RegExp, number, Samples][] = [
  [/^(met_uchar|unsigned char|uchar|uint8(_t)?)$/, 1, Uint8Array],
  [/^(met_char|signed char|char|int8(_t)?)$/, 1, Int8Array],
  [/^(met_ushort|unsigned short( int)?|ushort|uint16(_t)?)$/, 2, Uint16Array],
  [/^(met_short|short( int)?|signed short( int)?|int16(_t)?)$/, 2, Int16Array],
  [/^(met_uint|met_ulong|unsigned int|uint|uint32(_t)?)$/, 4, Uint32Array],
  [/^(met_int|met_long|int|signed int|int32(_t)?)$/, 4, Int32Array],
  [/^(met_float|float)$/, 4, Float32Array],
  [/^(met_double|double)$/, 8, Float64Array],
];

/** Read the first volume of a file; `format` is what it was found to be. Throws a sentence where it cannot be read. */
export async function readVolume(file: Blob, format: string): Promise<LabelVolume> {
  if (format.startsWith("dicom")) return readDicom(file, format);
  const content = await file.arrayBuffer();
  if (format === "nifti1") return readNifti(await inflate(content), true);
  if (format === "nrrd") return readNrrd(content);
  if (format === "metaimage") return readMetaImage(content);
  throw new Error("Volumes of this format are not drawn here.");
}

/** A volume whose header says where its samples lie: extents, axes in LPS or RAS mm, and how they are kept. */
async function samples(header: {
  shape: number[];
  /** x, y and z of each axis, and of the first voxel, in mm. */
  axes: number[][];
  origin: number[];
  lps: boolean;
  type: string;
  data: Uint8Array<ArrayBuffer>;
  packed: "gzip" | "deflate" | null;
  big: boolean;
}): Promise<LabelVolume> {
  const [nx = 0, ny = 0, nz = 0] = header.shape;
  const [, bytes, array] = TYPES.find(([name]) => name.test(header.type.toLowerCase())) ?? [null, 0, null];
  if (!array || nx * ny * nz === 0) throw new Error("The volume's voxels are of a type that is not drawn here.");
  const stream = header.packed && new Blob([header.data]).stream().pipeThrough(new DecompressionStream(header.packed));
  const content = stream ? await new Response(stream).arrayBuffer() : header.data.slice().buffer;
  const length = nx * ny * nz * bytes;
  if (content.byteLength < length) throw new Error("The file ends before its voxels do.");
  if (header.big) swap(new Uint8Array(content, 0, length), bytes);
  const affine = [0, 1, 2].flatMap((axis) => {
    const sign = header.lps && axis < 2 ? -1 : 1;
    return [...header.axes.slice(0, 3), header.origin].map((vector) => sign * (vector[axis] ?? 0));
  });
  return { shape: [nx, ny, nz], affine, values: new array(content, 0, nx * ny * nz), slope: 1, inter: 0 };
}

/** NRRD with its data in the same file (https://teem.sourceforge.net/nrrd/format.html). */
function readNrrd(content: ArrayBuffer): Promise<LabelVolume> {
  const bytes = new Uint8Array(content);
  const [head, begin] = headOf(bytes, (line) => line === "");
  const field = (name: string) =>
    head
      .find((line) => line.startsWith(`${name}:`))
      ?.slice(name.length + 1)
      .trim();
  const encoding = field("encoding") ?? "raw";
  const packed = encoding === "gzip" || encoding === "gz" ? "gzip" : null;
  const sizes = numbersIn(field("sizes") ?? "");
  if ((!packed && encoding !== "raw") || sizes.length < 3 || field("data file")) {
    throw new Error("This NRRD file is laid out in a way that is not drawn here.");
  }
  // What is no axis of space, as the components of a vector, says "none" and comes first or last.
  const kinds = field("space directions")?.match(/none|\([^)]*\)/g) ?? [];
  const leading = Math.max(
    0,
    kinds.findIndex((kind) => kind !== "none"),
  );
  if (leading > 0 && (sizes[0] ?? 1) > 1) throw new Error("This NRRD file has several values for each voxel.");
  const spacings = numbersIn(field("spacings") ?? "");
  const axes = [0, 1, 2].map((axis) => {
    const told = kinds[leading + axis];
    return told && told !== "none" ? numbersIn(told) : [0, 1, 2].map((k) => (k === axis ? (spacings[axis] ?? 1) : 0));
  });
  return samples({
    shape: sizes.slice(leading, leading + 3),
    axes,
    origin: numbersIn(field("space origin") ?? ""),
    lps: /^(left-posterior|lps)/i.test(field("space") ?? ""),
    type: field("type") ?? "",
    data: bytes.subarray(begin),
    packed,
    big: field("endian") === "big",
  });
}

/** MetaImage with its data in the same file (https://itk.org/Wiki/ITK/MetaIO/Documentation); LPS. */
function readMetaImage(content: ArrayBuffer): Promise<LabelVolume> {
  const bytes = new Uint8Array(content);
  const [head, begin] = headOf(bytes, (line) => /^ElementDataFile\s*=/.test(line));
  const field = (...names: string[]) =>
    head.find((line) => names.some((name) => new RegExp(`^${name}\\s*=`).test(line)))?.replace(/^\w+\s*=\s*/, "");
  if (field("ElementDataFile")?.toUpperCase() !== "LOCAL" || (field("ElementNumberOfChannels") ?? "1") !== "1") {
    throw new Error("This MetaImage file is laid out in a way that is not drawn here.");
  }
  const shape = numbersIn(field("DimSize") ?? "");
  const turn = numbersIn(field("TransformMatrix", "Rotation", "Orientation") ?? "1 0 0 0 1 0 0 0 1");
  const spacing = numbersIn(field("ElementSpacing", "ElementSize") ?? "1 1 1");
  const step = shape.length;
  return samples({
    shape: shape.slice(0, 3),
    axes: [0, 1, 2].map((axis) => [0, 1, 2].map((k) => (turn[step * axis + k] ?? 0) * (spacing[axis] ?? 1))),
    origin: numbersIn(field("Offset", "Origin", "Position") ?? ""),
    lps: true,
    type: field("ElementType") ?? "",
    data: bytes.subarray(begin),
    packed: field("CompressedData") === "True" ? "deflate" : null,
    big: (field("BinaryDataByteOrderMSB", "ElementByteOrderMSB") ?? "False") === "True",
  });
}

/** The lines of a header up to the one that ends it, and where the data begins. */
function headOf(bytes: Uint8Array, ends: (line: string) => boolean): [string[], number] {
  const lines: string[] = [];
  let begin = 0;
  while (begin < Math.min(bytes.length, 1 << 20)) {
    const end = bytes.indexOf(10, begin);
    if (end < 0) break;
    const line = new TextDecoder("latin1").decode(bytes.subarray(begin, end)).replace(/\r$/, "");
    lines.push(line);
    begin = end + 1;
    if (ends(line)) return [lines, begin];
  }
  throw new Error("The file's header has no end.");
}

function numbersIn(text: string): number[] {
  return (text.match(/[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?/gi) ?? []).map(Number);
}
