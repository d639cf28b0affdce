import { PAINT, PLAIN, partColor, type Rgb, TAKEN } from "@/viewers/shape/colors";
import type { ShapeModel } from "@/viewers/shape/model";

type Labels = readonly (number | null)[] | null;

/** A color for each corner of each face, red, green and blue, by the part of each vertex (null: of none). */
function colorCorners(model: ShapeModel, labels: Labels, color: (part: number | null) => Rgb): Float32Array {
  const { faces } = model.surface;
  const colors = new Float32Array(3 * faces.length);
  for (let i = 0; i < faces.length; i += 1) {
    colors.set(color(labels?.[faces[i] as number] ?? null), 3 * i);
  }
  return colors;
}

/** All alike, or each part of a level in its color. */
export function colorLevel(model: ShapeModel, level: number | null): Float32Array {
  return colorCorners(model, level === null ? null : model.labels(level), (part) =>
    part === null ? PLAIN : partColor(part),
  );
}

/** Parts in given colors, all others in one. */
export function colorParts(
  model: ShapeModel,
  level: number,
  colors: ReadonlyMap<number, Rgb>,
  others: Rgb,
): Float32Array {
  return colorCorners(model, model.labels(level), (part) => (part === null ? others : (colors.get(part) ?? others)));
}

/**
 * A found shape in the colors of the query's parts on a level, each where it was laid, with its own borders: of each
 * cell the part of the query's finest level that lies there is known. Null where cells are not.
 */
export function colorLaid(
  found: ShapeModel,
  laid: readonly number[],
  query: ShapeModel,
  level: number,
  others: Rgb,
): Float32Array | null {
  const finest = query.labels(query.levels.at(-1) ?? 0);
  const labels = query.labels(level);
  if (!found.cells || laid.length === 0 || !finest || !labels) return null;
  const above = new Map(finest.map((part, vertex) => [part, labels[vertex] as number]));
  const parts = found.cells.map((cell) => above.get(laid[cell] ?? -1) ?? null);
  return colorCorners(found, parts, (part) => (part === null ? others : partColor(part)));
}

/** What is painted, and the parts that it stands for. */
export function colorPainted(
  model: ShapeModel,
  level: number,
  painted: ReadonlySet<number>,
  taken: readonly number[],
): Float32Array {
  const used = new Set(taken);
  // parts are seen, but do not shine
  const colors = colorCorners(model, model.labels(level), (part) =>
    part === null ? PLAIN : used.has(part) ? TAKEN : mixed(PLAIN, partColor(part), 0.22),
  );
  for (const face of painted) for (let k = 0; k < 3; k += 1) colors.set(PAINT, 9 * face + 3 * k);
  return colors;
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
