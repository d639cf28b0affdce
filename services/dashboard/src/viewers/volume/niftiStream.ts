import { type NiftiHeader, readHeader, type Samples, type SamplesOf, swap, WHOLE_HEADER } from "@/format/nifti";
import { Blocks, stepsFor, type Triple } from "./reduce";

/** A volume as it is drawn: the file with fewer voxels, but for what says where they are. */
export interface Drawn {
  /** A NIfTI file that is not compressed, or the file as it came. */
  content: ArrayBuffer;
  /** How many voxels of the file became one along each axis; the header still tells where those of the file are. */
  steps: Triple;
}

interface Layout extends NiftiHeader {
  array: SamplesOf;
  steps: Triple;
  /** Of each voxel. */
  bytes: number;
}

/**
 * Takes a NIfTI-1 file piece by piece, uncompressed, and keeps no more of it than is drawn: the first of several
 * volumes, and where that is large, one voxel for a block of them. Other files are kept as they are.
 */
export class NiftiStream {
  readonly #most: number;
  readonly #labels: boolean;
  readonly #kept: Uint8Array[] = [];
  #bytes = 0;
  /** Null for what is kept as it is, once that is known. */
  #layout: Layout | null | undefined = undefined;
  #header = new Uint8Array(0);
  #blocks: Blocks<Samples> | null = null;
  #row = new Uint8Array(0);
  #filled = 0;
  #rows = 0;

  /** `most` voxels are kept; of `labels`, the largest of a block rather than the mean. */
  constructor(most: number, labels: boolean) {
    this.#most = most;
    this.#labels = labels;
  }

  /** Take the next piece; false when nothing that follows is needed. */
  push(piece: Uint8Array): boolean {
    if (this.#blocks) return this.#voxels(piece);
    this.#kept.push(piece);
    this.#bytes += piece.length;
    if (this.#layout === undefined && this.#bytes >= WHOLE_HEADER) this.#layout = layoutOf(this.#joined(), this.#most);
    const layout = this.#layout;
    if (!layout || this.#bytes < layout.offset || Math.max(...layout.steps) === 1) return true;
    const start = this.#joined();
    this.#kept.length = 0;
    this.#header = start.slice(0, WHOLE_HEADER);
    this.#blocks = new Blocks<Samples>(layout.array, layout.extent, layout.steps, this.#labels);
    this.#row = new Uint8Array(layout.extent[0] * layout.bytes);
    return this.#voxels(start.subarray(layout.offset));
  }

  /** What is drawn; throws a sentence where the file ends too early. */
  finish(): Drawn {
    const blocks = this.#blocks;
    const layout = this.#layout;
    if (!blocks || !layout) return { content: this.#joined().buffer, steps: [1, 1, 1] };
    const [, ny, nz] = layout.extent;
    if (this.#rows < ny * nz) throw new Error("The file ends before its voxels do.");
    const { samples, extent } = blocks;
    const content = new Uint8Array(WHOLE_HEADER + samples.byteLength);
    content.set(this.#header);
    const view = new DataView(content.buffer);
    view.setInt16(40, 3, layout.little);
    for (let axis = 1; axis <= 7; axis += 1) view.setInt16(40 + 2 * axis, extent[axis - 1] ?? 1, layout.little);
    view.setFloat32(108, WHOLE_HEADER, layout.little);
    view.setInt32(348, 0); // nothing between the header and the voxels
    const voxels = new Uint8Array(samples.buffer);
    if (!layout.little) swap(voxels, layout.bytes);
    content.set(voxels, WHOLE_HEADER);
    return { content: content.buffer, steps: layout.steps };
  }

  #joined(): Uint8Array<ArrayBuffer> {
    const all = new Uint8Array(this.#bytes);
    let at = 0;
    for (const piece of this.#kept) {
      all.set(piece, at);
      at += piece.length;
    }
    return all;
  }

  #voxels(piece: Uint8Array): boolean {
    const layout = this.#layout as Layout;
    const [, ny, nz] = layout.extent;
    for (let from = 0; from < piece.length && this.#rows < ny * nz;) {
      const some = piece.subarray(from, from + this.#row.length - this.#filled);
      this.#row.set(some, this.#filled);
      this.#filled += some.length;
      from += some.length;
      if (this.#filled < this.#row.length) break;
      if (!layout.little) swap(this.#row, layout.bytes);
      this.#blocks?.add(new layout.array(this.#row.buffer));
      this.#filled = 0;
      this.#rows += 1;
    }
    return this.#rows < ny * nz;
  }
}

/** How the voxels lie in a file that begins like this; null for one that is kept as it is. */
function layoutOf(start: Uint8Array, most: number): Layout | null {
  const header = readHeader(start);
  // Without a transform the middle of the volume is where space begins, which a coarser one would move.
  if (!header?.array || !header.single || !header.placed) return null;
  const { extent, array, offset } = header;
  if (Math.min(...extent) < 1 || offset < WHOLE_HEADER || offset > 2 ** 24) return null;
  return { ...header, array, steps: stepsFor(extent, most), bytes: new array(1).BYTES_PER_ELEMENT };
}
