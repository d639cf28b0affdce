import { PAINT, PLAIN, partColor, type Rgb, TAKEN } from "@/viewers/shape/colors";
import type { ShapeModel } from "@/viewers/shape/model";

/** A color for each face, red, green and blue. */
export function colorFaces(count: number, color: (face: number) => Rgb): Float32Array {
  const colors = new Float32Array(3 * count);
  for (let f = 0; f < count; f += 1) colors.set(color(f), 3 * f);
  return colors;
}

/** All alike, or each part of a level in its color. */
export function colorLevel(model: ShapeModel, level: number | null): Float32Array {
  const parts = level === null ? null : model.parts(level);
  return colorFaces(model.surface.areas.length, (f) => (parts ? partColor(parts[f] as number) : PLAIN));
}

/** Parts in given colors, all others in one. */
export function colorParts(
  model: ShapeModel,
  level: number,
  colors: ReadonlyMap<number, Rgb>,
  others: Rgb,
): Float32Array {
  const parts = model.parts(level);
  return colorFaces(model.surface.areas.length, (f) => (parts && colors.get(parts[f] as number)) ?? others);
}

/** What is painted, and the parts that it stands for. */
export function colorPainted(
  model: ShapeModel,
  level: number,
  painted: ReadonlySet<number>,
  taken: readonly number[],
): Float32Array {
  const parts = model.parts(level);
  const used = new Set(taken);
  return colorFaces(model.surface.areas.length, (f) => {
    if (painted.has(f)) return PAINT;
    const part = parts?.[f] ?? 0;
    return used.has(part) ? TAKEN : mixed(PLAIN, partColor(part), 0.22); // parts are seen, but do not shine
  });
}

function mixed(one: Rgb, other: Rgb, share: number): Rgb {
  const channel = (k: 0 | 1 | 2) => one[k] + share * (other[k] - one[k]);
  return [channel(0), channel(1), channel(2)];
}

/** The faces of some parts of a level. */
export function facesOf(model: ShapeModel, level: number, parts: ReadonlySet<number>): Int32Array {
  const own = model.parts(level) ?? new Int32Array();
  return Int32Array.from([...own.keys()].filter((face) => parts.has(own[face] as number)));
}
