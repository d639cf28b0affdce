import type { UseQueryResult } from "@tanstack/react-query";
import { Maximize } from "lucide-react";
import { type ReactNode, useEffect, useEffectEvent } from "react";
import { Tool } from "../Tool";
import { useDrawing } from "../useDrawing";
import { ViewerFrame, type ViewerStatus } from "../ViewerFrame";
import frame from "../viewers.module.css";
import type { Graph } from "./graph";
import type { ShapeModel } from "./model";
import { type OnPaint, ShapeCanvas } from "./ShapeCanvas";
import type { ViewLink } from "./ViewLink";

interface ShapeViewerProps {
  label: string;
  model: Pick<UseQueryResult, "error" | "refetch"> & { data: ShapeModel | undefined };
  /** Red, green and blue of each corner of each face. */
  colors: Float32Array | null;
  graph?: Graph | null;
  link?: ViewLink | null;
  /** Faces that the view begins with; null begins with the side that the picture shows. */
  focus?: Int32Array | null;
  /** While set, dragging on the shape paints. */
  onPaint?: OnPaint | null;
  tools?: ReactNode;
  /** Over the picture. */
  children?: ReactNode;
  testId?: string;
}

const WAITING = { is: "loading", fraction: null, what: "Loading the shape…" } as const;

/** A shape in space, each face in its color, with its graph drawn over it. */
export function ShapeViewer({
  label,
  model,
  colors,
  graph = null,
  link = null,
  focus = null,
  onPaint = null,
  tools,
  children,
  testId = "shape",
}: ShapeViewerProps) {
  const shape = model.data ?? null;
  const paints = onPaint !== null;

  const {
    parent,
    status: drawn,
    drawing: canvas,
    retry,
  } = useDrawing(shape, WAITING.what, ({ element, onLost, keep }) =>
    shape ? keep(new ShapeCanvas(element, shape, link, onLost)) : null,
  );

  useEffect(() => {
    canvas?.stage.tell(`${label} in 3D.`, testId);
  }, [canvas, label, testId]);
  useEffect(() => {
    if (canvas && colors) canvas.color(colors);
  }, [canvas, colors]);
  useEffect(() => {
    canvas?.drawGraph(graph);
  }, [canvas, graph]);
  useEffect(() => {
    if (canvas && focus) canvas.begin(focus);
  }, [canvas, focus]);
  const paint = useEffectEvent<OnPaint>((face, at) => onPaint?.(face, at));
  useEffect(() => {
    canvas?.paintWith(paints ? (face, at) => paint(face, at) : null);
  }, [canvas, paints]);

  const status: ViewerStatus = model.data ? drawn : model.error ? { is: "failed", error: model.error } : WAITING;
  return (
    <ViewerFrame
      label={label}
      status={status}
      onRetry={model.data ? retry : () => void model.refetch()}
      tools={
        <>
          {tools}
          <Tool
            label="Look at all of it"
            name={`Look at all of ${label}`}
            icon={Maximize}
            onClick={() => canvas?.look()}
          />
        </>
      }
    >
      <div ref={parent} className={frame.stage} />
      {children}
    </ViewerFrame>
  );
}
