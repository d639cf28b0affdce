import { niftiHeader, readNifti, type LabelVolume, type SamplesOf } from "@/format/nifti";
import { NiftiStream } from "@/viewers/volume/niftiStream";
import { coarserAffine } from "@/viewers/volume/reduce";
import { dicomAsNifti } from "./dicom";

const TYPES: readonly [RegExp, SamplesOf][] = [
  [/^(met_uchar|unsigned char|uchar|uint8(_t)?)$/, Uint8Array],
  [/^(met_char|signed char|char|int8(_t)?)$/, Int8Array],
  [/^(met_ushort|unsigned short( int)?|ushort|uint16(_t)?)$/, Uint16Array],
  [/^(met_short|short( int)?|signed short( int)?|int16(_t)?)$/, Int16Array],
  [/^(met_uint|met_ulong|unsigned int|uint|uint32(_t)?)$/, Uint32Array],
  [/^(met_int|met_long|int|signed int|int32(_t)?)$/, Int32Array],
  [/^(met_float|float)$/, Float32Array],
  [/^(met_double|double)$/, Float64Array],
];

/** A header is not longer. */
const LONGEST_HEADER = 1 << 20;

/**
 * A volume of any format as a NIfTI-1 file, which may be gzipped; `format` is what it was found to be. Voxels are not
 * read, but where they are packed or in slices: what comes back names the part of the file where they lie. Throws a
 * sentence where it cannot be read.
 */
export async function asNifti(file: Blob, format: string): Promise<Blob> {
  if (format.startsWith("dicom")) return dicomAsNifti(file, format);
  if (format === "nifti1") return file;
  if (format === "nrrd") return nrrdAsNifti(file);
  if (format === "metaimage") return metaImageAsNifti(file);
  throw new Error("Volumes of this format are not drawn here.");
}

/** Read the first volume of a NIfTI-1 file piece by piece, made coarser until it has at most `most` voxels. */
export async function readCoarse(file: Blob, most: number): Promise<LabelVolume> {
  const [one, other] = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  const packed = one === 0x1f && other === 0x8b;
  const reader = (packed ? file.stream().pipeThrough(new DecompressionStream("gzip")) : file.stream()).getReader();
  const stream = new NiftiStream(most, false);
  for (let more = true; more;) {
    const { done, value } = await reader.read();
    more = !done && stream.push(value);
  }
  reader.cancel().catch(() => undefined); // it has ended, or its end is not needed
  const { content, steps } = stream.finish();
  const volume = readNifti(content, true);
  const rows = [0, 4, 8].map((at) => volume.affine.slice(at, at + 4));
  return { ...volume, affine: coarserAffine(rows, steps).slice(0, 3).flat() };
}

/** A volume whose header says where its samples lie: extents, axes in LPS or RAS mm, and how they are kept. */
async function withSamples(header: {
  shape: number[];
  /** x, y and z of each axis, and of the first voxel, in mm. */
  axes: number[][];
  origin: number[];
  lps: boolean;
  type: string;
  data: Blob;
  packed: "gzip" | "deflate" | null;
  big: boolean;
}): Promise<Blob> {
  const [nx = 0, ny = 0, nz = 0] = header.shape;
  const [, array] = TYPES.find(([name]) => name.test(header.type.toLowerCase())) ?? [];
  if (!array || nx * ny * nz === 0) throw new Error("The volume's voxels are of a type that is not drawn here.");
  const { data, packed } = header;
  const voxels = packed ? await new Response(data.stream().pipeThrough(new DecompressionStream(packed))).blob() : data;
  const length = nx * ny * nz * new array(1).BYTES_PER_ELEMENT;
  if (voxels.size < length) throw new Error("The file ends before its voxels do.");
  const affine = [0, 1, 2].flatMap((axis) => {
    const sign = header.lps && axis < 2 ? -1 : 1;
    return [...header.axes.slice(0, 3), header.origin].map((vector) => sign * (vector[axis] ?? 0));
  });
  const facts = { shape: [nx, ny, nz] as [number, number, number], affine, slope: 1, inter: 0 };
  return new Blob([niftiHeader({ ...facts, array, little: !header.big }), voxels.slice(0, length)]);
}

/** NRRD with its data in the same file (https://teem.sourceforge.net/nrrd/format.html). */
async function nrrdAsNifti(file: Blob): Promise<Blob> {
  const [head, begin] = await headOf(file, (line) => line === "");
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
  return withSamples({
    shape: sizes.slice(leading, leading + 3),
    axes,
    origin: numbersIn(field("space origin") ?? ""),
    lps: /^(left-posterior|lps)/i.test(field("space") ?? ""),
    type: field("type") ?? "",
    data: file.slice(begin),
    packed,
    big: field("endian") === "big",
  });
}

/** MetaImage with its data in the same file (https://itk.org/Wiki/ITK/MetaIO/Documentation); LPS. */
async function metaImageAsNifti(file: Blob): Promise<Blob> {
  const [head, begin] = await headOf(file, (line) => /^ElementDataFile\s*=/.test(line));
  const field = (...names: string[]) =>
    head.find((line) => names.some((name) => new RegExp(`^${name}\\s*=`).test(line)))?.replace(/^\w+\s*=\s*/, "");
  if (field("ElementDataFile")?.toUpperCase() !== "LOCAL" || (field("ElementNumberOfChannels") ?? "1") !== "1") {
    throw new Error("This MetaImage file is laid out in a way that is not drawn here.");
  }
  const shape = numbersIn(field("DimSize") ?? "");
  const turn = numbersIn(field("TransformMatrix", "Rotation", "Orientation") ?? "1 0 0 0 1 0 0 0 1");
  const spacing = numbersIn(field("ElementSpacing", "ElementSize") ?? "1 1 1");
  const step = shape.length;
  return withSamples({
    shape: shape.slice(0, 3),
    axes: [0, 1, 2].map((axis) => [0, 1, 2].map((k) => (turn[step * axis + k] ?? 0) * (spacing[axis] ?? 1))),
    origin: numbersIn(field("Offset", "Origin", "Position") ?? ""),
    lps: true,
    type: field("ElementType") ?? "",
    data: file.slice(begin),
    packed: field("CompressedData") === "True" ? "deflate" : null,
    big: (field("BinaryDataByteOrderMSB", "ElementByteOrderMSB") ?? "False") === "True",
  });
}

/** The lines of a header up to the one that ends it, and where the data begins. */
async function headOf(file: Blob, ends: (line: string) => boolean): Promise<[string[], number]> {
  const bytes = new Uint8Array(await file.slice(0, LONGEST_HEADER).arrayBuffer());
  const lines: string[] = [];
  let begin = 0;
  while (begin < bytes.length) {
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
