import type { SurfaceMesh } from "@/viewers/surface/readSurface";

const [NEWLINE, RETURN, SPACE, TAB, SLASH, BACKSLASH, HASH] = [10, 13, 32, 9, 47, 92, 35];
const [PLUS, MINUS, DOT, ZERO, NINE] = [43, 45, 46, 48, 57];
/** Powers of ten that are exact in double precision. */
const TENS = Array.from({ length: 23 }, (_, power) => Number(`1e${power}`));

/** Reads words and numbers, line by line, from the bytes of a text: of a large one, no string is ever made. */
class Text {
  readonly #bytes: Uint8Array;
  #at = 0;

  constructor(content: ArrayBuffer) {
    this.#bytes = new Uint8Array(content);
  }

  /** Whether something is left of the line; a comment, or a line's end, is nothing. */
  more(): boolean {
    const bytes = this.#bytes;
    for (; this.#at < bytes.length; this.#at += 1) {
      const byte = bytes[this.#at];
      if (byte === BACKSLASH)
        this.#at += bytes[this.#at + 1] === RETURN ? 2 : 1; // the line goes on
      else if (byte !== SPACE && byte !== TAB && byte !== RETURN) return byte !== NEWLINE && byte !== HASH;
    }
    return false;
  }

  /** Go to the next line; false where there is none. */
  next(): boolean {
    const end = this.#bytes.indexOf(NEWLINE, this.#at);
    this.#at = end < 0 ? this.#bytes.length : end + 1;
    return this.#at < this.#bytes.length;
  }

  /** Go to the next line on which there is something. */
  nextFull(): boolean {
    while (this.next()) if (this.more()) return true;
    return false;
  }

  /** The next word, as far as a blank. */
  word(): string {
    const from = this.#at;
    this.skip();
    return String.fromCharCode(...this.#bytes.subarray(from, Math.min(this.#at, from + 64)));
  }

  /** Leave out what is left of a word. */
  skip(): void {
    const bytes = this.#bytes;
    while (this.#at < bytes.length && !ends(bytes[this.#at])) this.#at += 1;
  }

  /** The number that comes next, up to a blank or a slash; NaN where there is none. */
  number(): number {
    if (!this.more()) return Number.NaN;
    const bytes = this.#bytes;
    const from = this.#at;
    const negative = bytes[from] === MINUS;
    let at = negative || bytes[from] === PLUS ? from + 1 : from;
    let [value, digits, point] = [0, 0, -1];
    for (; ; at += 1) {
      const byte = bytes[at] ?? NEWLINE;
      if (byte >= ZERO && byte <= NINE) {
        value = 10 * value + (byte - ZERO);
        digits += 1;
      } else if (byte === DOT && point < 0) point = digits;
      else break;
    }
    const decimals = point < 0 ? 0 : digits - point;
    const last = bytes[at];
    if (digits > 0 && digits <= 15 && (ends(last) || last === SLASH)) {
      this.#at = at;
      // Both are exact, so that the quotient is as near as can be.
      return (negative ? -value : value) / (TENS[decimals] as number);
    }
    while (at < bytes.length && !ends(bytes[at]) && bytes[at] !== SLASH) at += 1;
    this.#at = at;
    return Number(String.fromCharCode(...bytes.subarray(from, Math.min(at, from + 64))));
  }
}

function ends(byte: number | undefined): boolean {
  return byte === undefined || byte === SPACE || byte === NEWLINE || byte === TAB || byte === RETURN;
}

/** Numbers of which nobody knows how many come. */
class Numbers<T extends Float32Array | Uint32Array> {
  #array: T;
  length = 0;

  constructor(array: T) {
    this.#array = array;
  }

  push(value: number): void {
    if (this.length === this.#array.length) {
      const larger = new (this.#array.constructor as new (length: number) => T)(2 * this.length);
      larger.set(this.#array);
      this.#array = larger;
    }
    this.#array[this.length] = value;
    this.length += 1;
  }

  all(): T {
    return this.#array.slice(0, this.length) as T;
  }
}

/** Read the polygons of a Wavefront OBJ file as fans of triangles; what is no vertex and no face is left out. */
export function readObj(content: ArrayBuffer): SurfaceMesh {
  const text = new Text(content);
  const positions = new Numbers(new Float32Array(3 << 12));
  const faces = new Numbers(new Uint32Array(3 << 12));
  do {
    if (!text.more()) continue;
    const kind = text.word();
    if (kind === "v") for (let axis = 0; axis < 3; axis += 1) positions.push(text.number());
    else if (kind === "f") {
      let [first, before] = [-1, -1];
      while (text.more()) {
        // From one, or backwards from the last; after a slash come what is not needed here.
        const told = text.number();
        text.skip();
        const corner = told < 0 ? positions.length / 3 + told : told - 1;
        if (first < 0) first = corner;
        else if (before < 0) before = corner;
        else {
          faces.push(first);
          faces.push(before);
          faces.push(corner);
          before = corner;
        }
      }
    }
  } while (text.next());
  return { positions: positions.all(), faces: faces.all() };
}

/** Read an Object File Format as text (Geomview): counts, vertices, and polygons, which become fans of triangles. */
export function readOff(content: ArrayBuffer): SurfaceMesh {
  const text = new Text(content);
  const refused = () => new Error("This OFF file cannot be drawn here.");
  if (!text.more() && !text.nextFull()) throw refused();
  const kind = text.word();
  // In four dimensions, in any number of them, or binary.
  if (!/^(ST|C|N)*OFF$/.test(kind) || (!text.more() && !text.nextFull())) throw refused();
  const [vertices, polygons] = [text.number(), text.number()];
  const positions = new Numbers(new Float32Array(3 << 12));
  const faces = new Numbers(new Uint32Array(3 << 12));
  for (let v = 0; v < vertices; v += 1) {
    if (!text.nextFull()) throw refused();
    for (let axis = 0; axis < 3; axis += 1) positions.push(text.number());
  }
  for (let f = 0; f < polygons; f += 1) {
    if (!text.nextFull()) throw refused();
    const count = text.number();
    const first = text.number();
    let before = text.number();
    for (let k = 2; k < count; k += 1) {
      const corner = text.number();
      faces.push(first);
      faces.push(before);
      faces.push(corner);
      before = corner;
    }
  }
  return { positions: positions.all(), faces: faces.all() };
}
