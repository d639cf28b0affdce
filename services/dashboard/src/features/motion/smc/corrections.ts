import { CorruptMotion } from "./container";
import { RangeDecoder } from "./rangeCoder";

const FRAME = 0;
const VERTEX = 64;
const MOVE = 128;

/** Steps added to single vertices, by the frame of the group: section 4 of api_schema/smc.md. */
export type Corrections = ReadonlyMap<number, [vertex: number, x: number, y: number, z: number][]>;

export function readCorrections(payload: Uint8Array, frames: number, vertices: number): Corrections {
  if (payload.length < 12) throw new CorruptMotion("CORR", "is too short");
  const view = new DataView(payload.buffer, payload.byteOffset, payload.length);
  const step = view.getFloat64(0, true);
  const count = view.getUint32(8, true);
  if (!(step > 0) || !Number.isFinite(step) || count > frames * vertices) {
    throw new CorruptMotion("CORR", "tells of more than there can be");
  }
  const decoder = new RangeDecoder(payload.subarray(12), 192);
  const found = new Map<number, [number, number, number, number][]>();
  let [frame, vertex] = [0, -1];
  const move = () => {
    const size = decoder.number(MOVE);
    return size > 0 && decoder.raw(1) ? -size * step : size * step;
  };
  for (let k = 0; k < count; k += 1) {
    const forward = decoder.number(FRAME);
    if (forward > 0) [frame, vertex] = [frame + forward, -1];
    vertex += 1 + decoder.number(VERTEX);
    if (frame >= frames || vertex >= vertices)
      throw new CorruptMotion("CORR", "names vertices or frames that are not there");
    const list = found.get(frame) ?? [];
    list.push([vertex, move(), move(), move()]);
    found.set(frame, list);
  }
  return found;
}
