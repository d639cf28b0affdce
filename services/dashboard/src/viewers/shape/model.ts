import { queryOptions } from "@tanstack/react-query";
import { apiFetch } from "@/api/client";
import { readGlb } from "./glb";
import { faceParts, partCenters, type Pose, placed, type Surface, surfaceOf, UPRIGHT, type Vector } from "./surface";

/** A shape's web mesh as it stands, with its parts on every level. */
export interface ShapeModel {
  surface: Surface;
  /** From where its picture was taken. */
  towards: Vector;
  /** The numbers of the levels, coarsest first. */
  levels: readonly number[];
  /** The part of each face: that of most of its corners. */
  parts: (level: number) => Int32Array | null;
  /** The part of each vertex. */
  labels: (level: number) => readonly number[] | null;
  /** The cell of each vertex; null where the shape was indexed before there were any. */
  cells: readonly number[] | null;
  /** Where each of `count` parts is. */
  centers: (level: number, count: number) => (Vector | null)[];
}

interface Components {
  vertices: number;
  /** Not told of shapes that were indexed before it was. */
  pose?: Pose;
  levels: { level: number; labels: number[] }[];
  cells?: number[];
}

export function modelOf(content: ArrayBuffer, components: Components): ShapeModel {
  const mesh = readGlb(content);
  if (components.vertices !== mesh.positions.length / 3) throw new Error("The mesh and its parts do not fit together.");
  const { frame, towards } = components.pose ?? UPRIGHT;
  const surface = surfaceOf(placed(mesh, frame));
  const parts = new Map(components.levels.map(({ level, labels }) => [level, faceParts(mesh.faces, labels)]));
  return {
    surface,
    towards,
    levels: components.levels.map(({ level }) => level),
    parts: (level) => parts.get(level) ?? null,
    labels: (level) => components.levels.find((one) => one.level === level)?.labels ?? null,
    cells: components.cells ?? null,
    centers: (level, count) => {
      const own = parts.get(level);
      return own ? partCenters(surface, own, count) : new Array<null>(count).fill(null);
    },
  };
}

/** What a viewer needs of a shape; `version` changes when it is indexed again. */
export const modelQuery = (meshUrl: string, componentsUrl: string, version = "") =>
  queryOptions({
    queryKey: ["shapes", "model", meshUrl, version],
    queryFn: async ({ signal }) => {
      const [mesh, components] = await Promise.all([
        apiFetch(meshUrl, { signal }).then((response) => response.arrayBuffer()),
        apiFetch(componentsUrl, { signal }).then((response) => response.json() as Promise<Components>),
      ]);
      return modelOf(mesh, components);
    },
    staleTime: Number.POSITIVE_INFINITY,
    gcTime: 60_000, // each is some megabytes
  });
