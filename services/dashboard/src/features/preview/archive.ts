/** A file inside of a zip archive. */
export interface ArchiveEntry {
  name: string;
  /** Bytes of its content. */
  size: number;
  /** Its content, or its first `most` bytes. */
  read(most?: number): Promise<ArrayBuffer>;
}

const [END, DIRECTORY, STORED, DEFLATED] = [0x06054b50, 0x02014b50, 0, 8];
const WHOLE = 0xffff_ffff;

/** List the files of a zip archive; nothing but its directory is read until one asks for more. Throws a sentence. */
export async function readArchive(archive: Blob): Promise<ArchiveEntry[]> {
  // The last record is followed by a comment of at most 64 kB.
  const tail = new DataView(await archive.slice(Math.max(0, archive.size - 65_557)).arrayBuffer());
  let at = tail.byteLength - 22;
  while (at >= 0 && tail.getUint32(at, true) !== END) at -= 1;
  if (at < 0) throw new Error("The archive is cut off.");
  const [count, length, begin] = [
    tail.getUint16(at + 10, true),
    tail.getUint32(at + 12, true),
    tail.getUint32(at + 16, true),
  ];
  if (begin === WHOLE || count === 0xffff) throw new Error("The archive is too large to be looked into here.");
  const directory = new DataView(await archive.slice(begin, begin + length).arrayBuffer());
  const entries: ArchiveEntry[] = [];
  for (let place = 0; entries.length < count && place + 46 <= directory.byteLength;) {
    if (directory.getUint32(place, true) !== DIRECTORY) throw new Error("The archive's directory is damaged.");
    const short = (offset: number) => directory.getUint16(place + offset, true);
    const long = (offset: number) => directory.getUint32(place + offset, true);
    const name = new TextDecoder().decode(new Uint8Array(directory.buffer, place + 46, short(28)));
    const [method, packed, size, start] = [short(10), long(20), long(24), long(42)];
    entries.push({ name, size, read: (most) => content(archive, { method, packed, size, start }, most) });
    place += 46 + short(28) + short(30) + short(32);
  }
  return entries;
}

interface Place {
  method: number;
  packed: number;
  size: number;
  start: number;
}

async function content(archive: Blob, { method, packed, size, start }: Place, most = size): Promise<ArrayBuffer> {
  const local = new DataView(await archive.slice(start, start + 30).arrayBuffer());
  const begin = start + 30 + local.getUint16(26, true) + local.getUint16(28, true);
  if (method === STORED) return archive.slice(begin, begin + Math.min(most, packed)).arrayBuffer();
  if (method !== DEFLATED) throw new Error("The archive is packed in a way that is not read here.");
  const stream = archive
    .slice(begin, begin + packed)
    .stream()
    .pipeThrough(new DecompressionStream("deflate-raw"));
  return most < size ? beginning(stream, most) : new Response(stream).arrayBuffer();
}

/** The first bytes of a stream, of which the rest is not read. */
async function beginning(stream: ReadableStream<Uint8Array>, most: number): Promise<ArrayBuffer> {
  const found = new Uint8Array(most);
  const reader = stream.getReader();
  let filled = 0;
  while (filled < most) {
    const { done, value } = await reader.read();
    if (done) break;
    const some = value.subarray(0, most - filled);
    found.set(some, filled);
    filled += some.length;
  }
  await reader.cancel();
  return found.buffer.slice(0, filled);
}

/** Whether a file inside of an archive is a mesh, going by its name. */
export function isMeshName(name: string): boolean {
  return /(^|\/)[^./][^/]*\.(obj|ply|stl|off|glb)$/i.test(name);
}
