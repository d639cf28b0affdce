import { partColor, type Rgb } from "./colors";
import type { ShapeModel } from "./model";
import type { Vector } from "./surface";

/** One level of a shape's hierarchy, as the API tells it. */
export interface Level {
  level: number;
  masses: readonly number[];
  parents: readonly number[];
  edges: readonly (readonly number[])[];
}

export interface GraphNode {
  at: Vector;
  /** Radius, where the shape's own is 1. */
  size: number;
  color: Rgb;
}

/** The attributed relational graph as it is drawn: one level, the level above it, and what ties them. */
export interface Graph {
  nodes: GraphNode[];
  /** Pairs of places in `nodes`. */
  neighbours: [number, number][];
  parents: [number, number][];
}

const ABOVE: Rgb = [0.96, 0.97, 0.97];

/** The parts of a level at their centers; those of the level above between the parts that they hold. */
export function graphOf(model: ShapeModel, levels: readonly Level[], level: number): Graph {
  const graph: Graph = { nodes: [], neighbours: [], parents: [] };
  const own = levels.find((one) => one.level === level);
  if (!own) return graph;
  const add = (at: Vector, size: number, color: Rgb) => graph.nodes.push({ at, size, color }) - 1;
  const centers = model.centers(level, own.masses.length);
  const children = new Map<number, number[]>();
  own.parents.forEach((parent, part) => children.set(parent, [...(children.get(parent) ?? []), part]));
  // The level above comes first, and is drawn behind: a part that it holds alone is a dot with a rim.
  const above = new Map<number, number>();
  for (const [parent, parts] of children) {
    const there = parts.filter((part) => centers[part]);
    const mass = there.reduce((sum, part) => sum + (own.masses[part] ?? 0), 0);
    if (mass === 0) continue;
    const at = [0, 1, 2].map((axis) =>
      there.reduce((sum, part) => sum + ((own.masses[part] ?? 0) / mass) * (centers[part]?.[axis] ?? 0), 0),
    ) as unknown as Vector;
    above.set(parent, add(at, (there.length === 1 ? 1.35 : 0.9) * size(mass), ABOVE));
  }
  const nodes = own.masses.map((mass, part) => {
    const at = centers[part];
    return at ? add(at, size(mass), partColor(part)) : null;
  });
  const tie = (into: [number, number][], from: number | null | undefined, to: number | null | undefined) => {
    if (typeof from === "number" && typeof to === "number") into.push([from, to]);
  };
  for (const [one = -1, other = -1] of own.edges) tie(graph.neighbours, nodes[one], nodes[other]);
  own.parents.forEach((parent, part) => tie(graph.parents, nodes[part], above.get(parent)));
  return graph;
}

function size(mass: number): number {
  return 0.014 + 0.06 * Math.sqrt(mass);
}
