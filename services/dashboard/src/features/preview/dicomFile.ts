/** Elements by their tag: group and element as one number. */
export type Dataset = ReadonlyMap<number, Element>;

export interface Element {
  /** Where its value is in the file, and how many bytes it has. */
  at: number;
  length: number;
  /** The items of a sequence. */
  items: Dataset[] | null;
}

/** A DICOM file whose pixels lie in it as they are. */
export interface DicomFile {
  view: DataView;
  little: boolean;
  elements: Dataset;
}

const [IMPLICIT, EXPLICIT, BIG, DEFLATED] = ["1.2", "1.2.1", "1.2.2", "1.2.1.99"].map((end) => `1.2.840.10008.${end}`);
const LONG = new Set(["OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"]);
const [ITEM, ITEM_END, SEQUENCE_END, UNKNOWN_LENGTH] = [0xfffee000, 0xfffee00d, 0xfffee0dd, 0xffff_ffff];
export const PIXELS = 0x7fe00010;
/** Sequences that hold what is asked for; without types in the file they are known by their tags. */
const SEQUENCES = new Set([0x52009229, 0x52009230, 0x00209113, 0x00209116, 0x00289110, 0x00289145]);
const DEEPEST = 16;

/**
 * Read the elements of a DICOM file (PS3.10, encoded as PS3.5 section 7 says); null where it is none. Throws a sentence
 * where its pixels are compressed, which needs decoders that a browser has not.
 */
export async function parseDicom(content: ArrayBuffer): Promise<DicomFile | null> {
  if (content.byteLength < 140 || text(new DataView(content), 128, 4) !== "DICM") return null;
  const meta = new Reader(new DataView(content), true, true);
  const head = meta.dataset(132, content.byteLength, 0, (tag) => tag >>> 16 !== 2);
  const syntax = head.elements.get(0x00020010);
  const named = syntax ? text(meta.view, syntax.at, syntax.length) : IMPLICIT;
  if (![IMPLICIT, EXPLICIT, BIG, DEFLATED].includes(named)) {
    throw new Error("The pixels of this DICOM series are compressed, which browsers do not read.");
  }
  let [body, begin] = [content, head.end];
  if (named === DEFLATED) {
    const stream = new Blob([content.slice(begin)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    [body, begin] = [await new Response(stream).arrayBuffer(), 0];
  }
  const reader = new Reader(new DataView(body), named !== BIG, named !== IMPLICIT);
  return {
    view: reader.view,
    little: named !== BIG,
    elements: reader.dataset(begin, body.byteLength, 0, () => false).elements,
  };
}

/** The series that a file belongs to, going by its first bytes; null where it is no DICOM file or does not say. */
export function seriesOf(head: ArrayBuffer): { uid: string; name: string } | null {
  if (head.byteLength < 140 || text(new DataView(head), 128, 4) !== "DICM") return null;
  const meta = new Reader(new DataView(head), true, true);
  const { elements: first, end } = meta.dataset(132, head.byteLength, 0, (tag) => tag >>> 16 !== 2);
  const syntax = first.get(0x00020010);
  const named = syntax ? text(meta.view, syntax.at, syntax.length) : IMPLICIT;
  if (named === DEFLATED) return null;
  // Compressed pixels lie in files that are written as explicitly as others.
  const body = new Reader(meta.view, named !== BIG, named !== IMPLICIT);
  const { elements } = body.dataset(end, head.byteLength, 0, (tag) => tag > 0x0020000e);
  const told = (tag: number) => {
    const element = elements.get(tag);
    return element && element.at + element.length <= head.byteLength ? text(body.view, element.at, element.length) : "";
  };
  const uid = told(0x0020000e);
  return uid ? { uid, name: told(0x0008103e) } : null;
}

class Reader {
  constructor(
    readonly view: DataView,
    readonly little: boolean,
    readonly explicit: boolean,
  ) {}

  /** The elements from `at` on, until the end, the end of an item, or what `stops`. */
  dataset(
    at: number,
    end: number,
    depth: number,
    stops: (tag: number) => boolean,
  ): { elements: Map<number, Element>; end: number } {
    const elements = new Map<number, Element>();
    while (at + 8 <= end) {
      const tag = this.#tag(at);
      if (stops(tag)) break;
      if (tag === ITEM_END || tag === SEQUENCE_END) return { elements, end: at + 8 };
      const { type, value, length } = this.#header(at);
      if (length === UNKNOWN_LENGTH && tag === PIXELS)
        throw new Error("The pixels of this DICOM series are compressed.");
      const nested = type === "SQ" || length === UNKNOWN_LENGTH || (type === "" && SEQUENCES.has(tag));
      if (nested && depth < DEEPEST) {
        const sequence = this.#sequence(
          value,
          length === UNKNOWN_LENGTH ? end : Math.min(end, value + length),
          depth,
          length,
        );
        elements.set(tag, { at: value, length, items: sequence.items });
        at = sequence.end;
      } else {
        elements.set(tag, { at: value, length, items: null });
        at = value + length;
      }
    }
    return { elements, end: at };
  }

  #sequence(at: number, end: number, depth: number, length: number): { items: Dataset[]; end: number } {
    const items: Dataset[] = [];
    while (at + 8 <= end) {
      const tag = this.#tag(at);
      const size = this.view.getUint32(at + 4, this.little);
      at += 8;
      if (tag === SEQUENCE_END) return { items, end: at };
      if (tag !== ITEM) throw new Error("A sequence of this DICOM file is damaged.");
      const item = this.dataset(at, size === UNKNOWN_LENGTH ? end : Math.min(end, at + size), depth + 1, () => false);
      items.push(item.elements);
      at = size === UNKNOWN_LENGTH ? item.end : at + size;
    }
    return { items, end: length === UNKNOWN_LENGTH ? at : end };
  }

  #tag(at: number): number {
    return this.view.getUint16(at, this.little) * 65536 + this.view.getUint16(at + 2, this.little);
  }

  #header(at: number): { type: string; value: number; length: number } {
    if (!this.explicit) return { type: "", value: at + 8, length: this.view.getUint32(at + 4, this.little) };
    const type = text(this.view, at + 4, 2);
    return LONG.has(type)
      ? { type, value: at + 12, length: this.view.getUint32(at + 8, this.little) }
      : { type, value: at + 8, length: this.view.getUint16(at + 6, this.little) };
  }
}

/** Characters without the zeros and blanks that fill them up. */
export function text(view: DataView, at: number, length: number): string {
  const bytes = new Uint8Array(view.buffer, view.byteOffset + at, Math.min(length, view.byteLength - at));
  return new TextDecoder("latin1").decode(bytes).replace(/[\0 ]+$/, "");
}
