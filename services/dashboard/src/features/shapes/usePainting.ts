import { useMemo, useState } from "react";
import { Brush, NOTHING, type Painted, paintedParts } from "@/viewers/shape/brush";
import type { ShapeModel } from "@/viewers/shape/model";
import { colorPainted } from "./coloring";

export interface Painting {
  /** What is painted now. */
  painted: Painted;
  colors: Float32Array | null;
  /** Radius of the brush, where the shape's own is 1. */
  radius: number;
  erase: boolean;
  setRadius: (radius: number) => void;
  setErase: (erase: boolean) => void;
  onPaint: (face: number, at: [number, number, number]) => void;
  /** Paint a whole part, or clean it. */
  toggle: (part: number) => void;
  clear: () => void;
}

/** A region painted on a shape; it begins with `first`, parts of the finest level. */
export function usePainting(model: ShapeModel | undefined, first: readonly number[] = []): Painting {
  const [radius, setRadius] = useState(0.14);
  const [erase, setErase] = useState(false);
  // The brush changes in place: after each stroke a copy of what it has painted is shown.
  const [state, setState] = useState<{ brush: Brush; faces: ReadonlySet<number> } | null>(null);
  const key = first.join(" ");
  const brush = useMemo(() => {
    if (!model) return null;
    const made = new Brush(model.surface);
    const parts = model.parts(finest(model));
    const wanted = new Set(key === "" ? [] : key.split(" ").map(Number));
    parts?.forEach((part, face) => {
      if (wanted.has(part)) made.painted.add(face);
    });
    return made;
  }, [model, key]);
  const faces = state !== null && state.brush === brush ? state.faces : brush?.painted;
  const [painted, colors] = useMemo(() => {
    const parts = model?.parts(finest(model));
    if (!model || !faces || !parts) return [NOTHING, null];
    const now = paintedParts(model.surface, parts, faces);
    return [now, colorPainted(model, finest(model), faces, now.parts)];
  }, [model, faces]);
  const changed = () => setState(brush && { brush, faces: new Set(brush.painted) });
  return {
    painted,
    colors,
    radius,
    erase,
    setRadius,
    setErase,
    onPaint: (face, at) => {
      if (brush?.stroke(face, at, radius, erase)) changed();
    },
    toggle: (part) => {
      const on = !painted.parts.includes(part);
      model?.parts(finest(model))?.forEach((own, face) => {
        if (own !== part) return;
        if (on) brush?.painted.add(face);
        else brush?.painted.delete(face);
      });
      changed();
    },
    clear: () => {
      brush?.clear();
      changed();
    },
  };
}

export function finest(model: ShapeModel): number {
  return Math.max(...model.levels);
}
