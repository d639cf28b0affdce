import type { Surface } from "./surface";

/** Paints faces of a mesh: those within a ball that hang together with the face that was touched. */
export class Brush {
  readonly painted: Set<number> = new Set();
  readonly #surface: Surface;
  readonly #around: Int32Array;
  readonly #begins: Int32Array;

  constructor(surface: Surface) {
    this.#surface = surface;
    // Faces by their vertices, so that also faces that touch in one vertex are neighbours.
    const { faces, positions } = surface;
    const begins = new Int32Array(positions.length / 3 + 1);
    for (const v of faces) begins[v + 1] = (begins[v + 1] as number) + 1;
    for (let v = 1; v < begins.length; v += 1) begins[v] = (begins[v] as number) + (begins[v - 1] as number);
    const next = begins.slice();
    this.#around = new Int32Array(faces.length);
    for (let i = 0; i < faces.length; i += 1) {
      const v = faces[i] as number;
      this.#around[next[v] as number] = Math.floor(i / 3);
      next[v] = (next[v] as number) + 1;
    }
    this.#begins = begins;
  }

  /** Paint, or with `erase` clean, around a point of a face; tells whether anything has changed. */
  stroke(face: number, [x, y, z]: readonly [number, number, number], radius: number, erase: boolean): boolean {
    const { middles, faces } = this.#surface;
    const before = this.painted.size;
    const seen = new Set([face]);
    const open = [face];
    for (let f = open.pop(); f !== undefined; f = open.pop()) {
      if (erase) this.painted.delete(f);
      else this.painted.add(f);
      for (let k = 0; k < 3; k += 1) {
        const v = faces[3 * f + k] as number;
        for (let i = this.#begins[v] as number; i < (this.#begins[v + 1] as number); i += 1) {
          const other = this.#around[i] as number;
          if (seen.has(other)) continue;
          seen.add(other);
          const away = Math.hypot(
            (middles[3 * other] as number) - x,
            (middles[3 * other + 1] as number) - y,
            (middles[3 * other + 2] as number) - z,
          );
          if (away <= radius) open.push(other);
        }
      }
    }
    return this.painted.size !== before;
  }

  clear(): void {
    this.painted.clear();
  }
}

/** What is painted of a shape, as a search takes it. */
export interface Painted {
  /** Share of the surface's area that is painted. */
  share: number;
  /** The parts of the finest level that are searched with: those painted at least by half, or the fullest one. */
  parts: number[];
  /** Share of the surface's area that these parts have. */
  used: number;
}

export const NOTHING: Painted = { share: 0, parts: [], used: 0 };

export function paintedParts(surface: Surface, parts: Int32Array, painted: ReadonlySet<number>): Painted {
  if (painted.size === 0) return NOTHING;
  const count = parts.reduce((most, part) => Math.max(most, part), -1) + 1;
  const [whole, inside] = [new Float64Array(count), new Float64Array(count)];
  for (let f = 0; f < parts.length; f += 1) {
    const part = parts[f] as number;
    const area = surface.areas[f] as number;
    whole[part] = (whole[part] as number) + area;
    if (painted.has(f)) inside[part] = (inside[part] as number) + area;
  }
  const numbers = [...whole.keys()];
  let chosen = numbers.filter((part) => (inside[part] as number) >= (whole[part] as number) / 2 && inside[part]);
  if (chosen.length === 0) {
    chosen = [numbers.reduce((best, part) => ((inside[part] as number) > (inside[best] as number) ? part : best), 0)];
  }
  const total = surface.area || 1;
  const sum = (values: Float64Array, of: number[]) => of.reduce((so, part) => so + (values[part] as number), 0);
  return { share: sum(inside, numbers) / total, parts: chosen, used: sum(whole, chosen) / total };
}
