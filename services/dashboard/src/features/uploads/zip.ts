/** One file of an archive. */
export interface ZipEntry {
  path: string;
  content: Blob;
}

const TABLE = new Uint32Array(256).map((_, index) => {
  let value = index;
  for (let bit = 0; bit < 8; bit += 1) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value >>> 0;
});

function crc32(bytes: Uint8Array, seed: number): number {
  let value = ~seed;
  for (const byte of bytes) value = (value >>> 8) ^ (TABLE[(value ^ byte) & 0xff] as number);
  return ~value >>> 0;
}

/** The CRC-32 of a blob, read in pieces so that a large file never lies in memory as a whole. */
export async function checksum(content: Blob): Promise<number> {
  let value = 0;
  const reader = content.stream().getReader();
  for (;;) {
    const { done, value: chunk } = await reader.read();
    if (done) return value;
    value = crc32(chunk, value);
  }
}

const LIMIT = 0xffff_ffff;

/**
 * Put files into one zip without compressing them, so that a folder travels as one resumable upload.
 *
 * The archive is a list of references to the files' bytes: only headers are made here. The same files give the same
 * bytes, so an interrupted upload goes on after the folder is chosen again.
 */
export async function zip(
  entries: readonly ZipEntry[],
  onProgress: (fraction: number) => void = () => undefined,
  signal?: AbortSignal,
): Promise<Blob> {
  const sorted = [...entries].sort((one, other) => (one.path < other.path ? -1 : one.path > other.path ? 1 : 0));
  const total = sorted.reduce((sum, { content }) => sum + content.size, 0);
  if (sorted.length > 0xffff || total + sorted.length * 512 > LIMIT) {
    throw new RangeError(
      `A folder may hold up to 65 535 files and 4 GB to be sent as one; this one has ${sorted.length} files and ` +
        `${(total / 1e9).toFixed(1)} GB. Zip it and upload the archive.`,
    );
  }
  const parts: BlobPart[] = [];
  const directory: Uint8Array<ArrayBuffer>[] = [];
  let offset = 0;
  for (const { path, content } of sorted) {
    signal?.throwIfAborted();
    const name = new TextEncoder().encode(path);
    const shared = sharedFields(await checksum(content), content.size, name.length);
    const local = concatenate(littleEndian(0x04034b50, 4), shared, littleEndian(0, 2), name);
    parts.push(local, content);
    directory.push(
      concatenate(
        littleEndian(0x02014b50, 4),
        littleEndian(20, 2), // made by: version 2.0
        shared,
        littleEndian(0, 2), // no extra field
        littleEndian(0, 2), // no comment
        littleEndian(0, 2), // disk
        littleEndian(0, 2), // internal attributes
        littleEndian(0, 4), // external attributes
        littleEndian(offset, 4),
        name,
      ),
    );
    offset += local.length + content.size;
    onProgress(total > 0 ? Math.min(offset / total, 1) : 1);
  }
  const length = directory.reduce((sum, record) => sum + record.length, 0);
  const end = concatenate(
    littleEndian(0x06054b50, 4),
    littleEndian(0, 4), // disks
    littleEndian(sorted.length, 2),
    littleEndian(sorted.length, 2),
    littleEndian(length, 4),
    littleEndian(offset, 4),
    littleEndian(0, 2),
  );
  return new Blob([...parts, ...directory, end], { type: "application/zip" });
}

/** The fields that the local and the central header share, from the version to the length of the name. */
function sharedFields(crc: number, size: number, nameLength: number): Uint8Array<ArrayBuffer> {
  return concatenate(
    littleEndian(20, 2), // version 2.0 extracts it
    littleEndian(0x0800, 2), // names are UTF-8
    littleEndian(0, 2), // stored
    littleEndian(0, 2), // time and date are left at 1980-01-01: the same files give the same bytes
    littleEndian(0x21, 2),
    littleEndian(crc, 4),
    littleEndian(size, 4),
    littleEndian(size, 4),
    littleEndian(nameLength, 2),
  );
}

function littleEndian(value: number, width: 2 | 4): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(width);
  for (let index = 0; index < width; index += 1) bytes[index] = Math.floor(value / 256 ** index) & 0xff;
  return bytes;
}

function concatenate(...parts: Uint8Array[]): Uint8Array<ArrayBuffer> {
  const result = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let offset = 0;
  for (const part of parts) {
    result.set(part, offset);
    offset += part.length;
  }
  return result;
}
