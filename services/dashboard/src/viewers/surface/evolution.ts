/** Surfaces as they grew, or as they grow just now: api_schema/evolution.md. */

export interface Frame {
  /** The object's number, from 1. */
  object: number;
  stage: number;
  iteration: number;
  /** x, y, z of each vertex in RAS mm. */
  positions: Float32Array;
  /** Three vertices each, counter-clockwise seen from outside. */
  faces: Uint32Array;
}

const MAGIC = "SHPEVO1\0";
const LARGEST = 64 << 20;

/** Read all frames of a file; throws a sentence where it is damaged. */
export function readEvolution(content: ArrayBuffer): Frame[] {
  if (content.byteLength < 12 || content.byteLength > LARGEST || text(content, 0, 8) !== MAGIC) {
    throw new Error("The file is no evolution of a surface.");
  }
  const body = 12 + new DataView(content).getUint32(8, true);
  if (body > content.byteLength) throw damaged("its header is cut off");
  let header: unknown;
  try {
    header = JSON.parse(text(content, 12, body - 12));
  } catch {
    throw damaged("its header is no JSON");
  }
  if (!isHeader(header)) throw damaged("its header lacks what it should tell");
  const { origin, step, frames } = header;
  return frames.map(({ object, stage, iteration, vertices, faces, offset }) => {
    const begin = body + offset;
    const corners = begin + Math.ceil((6 * vertices) / 4) * 4;
    if (begin % 4 !== 0 || corners + 12 * faces > content.byteLength) throw damaged("a frame is cut off");
    const places = new Uint16Array(content, begin, 3 * vertices);
    const indices = new Uint32Array(content, corners, 3 * faces).slice();
    if (indices.some((index) => index >= vertices)) throw damaged("a face has no such vertex");
    const positions = Float32Array.from(places, (value, index) => (origin[index % 3] ?? 0) + step * value);
    return { object, stage, iteration, positions, faces: indices };
  });
}

/** What is seen at one moment of an evolution: the frame of that moment, and the objects that rest before it. */
export function sceneAt(frames: readonly Frame[], index: number): Frame[] {
  const now = frames[index];
  if (!now) return [];
  const ended = new Map<number, Frame>();
  for (const frame of frames.slice(0, index)) if (frame.object !== now.object) ended.set(frame.object, frame);
  return [...ended.values(), now];
}

interface Header {
  origin: [number, number, number];
  step: number;
  frames: { object: number; stage: number; iteration: number; vertices: number; faces: number; offset: number }[];
}

const COUNTS = ["object", "stage", "iteration", "vertices", "faces", "offset"] as const;

function isHeader(header: unknown): header is Header {
  if (typeof header !== "object" || header === null) return false;
  const { origin, step, frames } = header as Partial<Header>;
  return (
    Array.isArray(origin) &&
    origin.length === 3 &&
    origin.every(Number.isFinite) &&
    Number.isFinite(step) &&
    Array.isArray(frames) &&
    frames.every((frame) => COUNTS.every((name) => Number.isSafeInteger(frame[name]) && frame[name] >= 0))
  );
}

function text(content: ArrayBuffer, at: number, length: number): string {
  return new TextDecoder().decode(new Uint8Array(content, at, length));
}

function damaged(how: string): Error {
  return new Error(`The evolution of the surface is damaged: ${how}.`);
}
