/** Sections and header of a motion file: section 1 of api_schema/smc.md. */

export class CorruptMotion extends Error {
  override readonly name = "CorruptMotion";
  constructor(
    readonly section: string,
    what: string,
  ) {
    super(`The motion file is damaged: section ${section.trim()} ${what}.`);
  }
}

export interface Group {
  first: number;
  frames: number;
  offset: number;
  length: number;
}

export interface Bounds {
  kgPercent: number;
  rmseEdges: number;
  largestFraction: number;
}

export interface Header {
  profile: "trajectory" | "gradient";
  /** Whether the original was in double precision. */
  double: boolean;
  vertices: number;
  faces: number;
  frames: number;
  memory: number;
  /** Frames per second, 0 if unknown. */
  fps: number;
  asked: Bounds;
  met: Bounds;
  name: string;
  unit: string;
  groups: Group[];
}

const MAGIC = [0x53, 0x4d, 0x43, 0x31, 0x0d, 0x0a, 0x1a, 0x0a];
const MAX_MEMORY = 2 ** 31;
const MAX_VERTICES = 20_000_000;
const MAX_GROUP_FRAMES = 4096;

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let k = 0; k < 8; k += 1) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value >>> 0;
});

export function crc32(bytes: Uint8Array): number {
  let value = 0xffffffff;
  for (const byte of bytes) value = (CRC_TABLE[(value ^ byte) & 255] ?? 0) ^ (value >>> 8);
  return (value ^ 0xffffffff) >>> 0;
}

/** Reads sections one after the other between two places of a file. */
export class SectionReader {
  offset: number;
  constructor(
    readonly bytes: Uint8Array,
    start: number,
    readonly end: number,
  ) {
    this.offset = start;
  }

  next(wanted?: string): { tag: string; payload: Uint8Array } {
    const { bytes, offset, end } = this;
    if (offset + 12 > end) throw new CorruptMotion(wanted ?? "header", "is cut off");
    const view = new DataView(bytes.buffer, bytes.byteOffset);
    const tag = String.fromCharCode(...bytes.subarray(offset, offset + 4));
    if (wanted !== undefined && tag !== wanted) throw new CorruptMotion(wanted, "is not where it has to be");
    const length = view.getUint32(offset + 4, true);
    if (offset + 12 + length > end) throw new CorruptMotion(tag, "is cut off");
    const check = view.getUint32(offset + 8 + length, true);
    if (crc32(bytes.subarray(offset, offset + 8 + length)) !== check) {
      throw new CorruptMotion(tag, "has another checksum than its content");
    }
    this.offset = offset + 12 + length;
    return { tag, payload: bytes.subarray(offset + 8, offset + 8 + length) };
  }
}

/** Read everything before the first group: the header, and the payload of the connectivity. */
export function readHeader(bytes: Uint8Array): { header: Header; connectivity: Uint8Array } {
  if (MAGIC.some((byte, at) => bytes[at] !== byte))
    throw new CorruptMotion("HEAD", "is not there: this is no motion file");
  const reader = new SectionReader(bytes, MAGIC.length, bytes.length);
  const head = reader.next("HEAD").payload;
  if (head.length < 92) throw new CorruptMotion("HEAD", "is too short");
  const view = new DataView(head.buffer, head.byteOffset, head.length);
  if (view.getUint8(0) !== 1)
    throw new CorruptMotion("HEAD", `is of version ${view.getUint8(0)}, which is not known here`);
  const profile = ([null, "trajectory", "gradient"] as const)[view.getUint8(2)];
  if (!profile) throw new CorruptMotion("HEAD", "names a profile that is not known here");
  const [vertices = 0, faces = 0, frames = 0, count = 0] = [4, 8, 12, 16].map((at) => view.getUint32(at, true));
  if (Number(view.getBigUint64(20, true)) !== bytes.length)
    throw new CorruptMotion("HEAD", "tells of another length than the file has");
  const memory = Number(view.getBigUint64(28, true));
  if (memory > MAX_MEMORY || vertices > MAX_VERTICES || faces > 2 * MAX_VERTICES) {
    throw new CorruptMotion("HEAD", "asks for more memory than this player gives");
  }
  // what any group of so many vertices takes: nothing is made for vertices that the memory does not hold
  if (memory < (profile === "trajectory" ? 400 : 28) * vertices)
    throw new CorruptMotion("HEAD", "tells of more vertices than its memory holds");
  const bounds = (at: number): Bounds => ({
    kgPercent: view.getFloat64(at, true),
    rmseEdges: view.getFloat64(at + 8, true),
    largestFraction: view.getFloat64(at + 16, true),
  });
  const meta = readMeta(reader.next("META").payload);
  const groups = readGroups(reader.next("GRPS").payload, count, frames, bytes.length);
  return {
    header: {
      profile,
      double: (view.getUint8(3) & 1) === 1,
      vertices,
      faces,
      frames,
      memory,
      fps: view.getFloat64(36, true),
      asked: bounds(44),
      met: bounds(68),
      ...meta,
      groups,
    },
    connectivity: reader.next("CONN").payload,
  };
}

function readMeta(payload: Uint8Array): { name: string; unit: string } {
  let meta: unknown;
  try {
    meta = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(payload));
  } catch {
    throw new CorruptMotion("META", "is no JSON");
  }
  const text = (name: string) => {
    const value: unknown = typeof meta === "object" && meta !== null ? Reflect.get(meta, name) : null;
    return typeof value === "string" ? value : "";
  };
  return { name: text("name"), unit: text("unit") };
}

function readGroups(payload: Uint8Array, count: number, frames: number, length: number): Group[] {
  if (payload.length !== 24 * count || count < 1 || count > frames)
    throw new CorruptMotion("GRPS", "has another length");
  const view = new DataView(payload.buffer, payload.byteOffset, payload.length);
  const groups: Group[] = [];
  let first = 0;
  for (let at = 0; at < payload.length; at += 24) {
    const group = {
      first: view.getUint32(at, true),
      frames: view.getUint32(at + 4, true),
      offset: Number(view.getBigUint64(at + 8, true)),
      length: Number(view.getBigUint64(at + 16, true)),
    };
    const fits = group.frames >= 1 && group.frames <= MAX_GROUP_FRAMES && group.offset + group.length <= length;
    if (group.first !== first || !fits) throw new CorruptMotion("GRPS", "has a gap, or leads out of the file");
    first += group.frames;
    groups.push(group);
  }
  if (first !== frames) throw new CorruptMotion("GRPS", "tells of another number of frames");
  return groups;
}
