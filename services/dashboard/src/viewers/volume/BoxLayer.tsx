import { type PointerEvent, useEffect, useRef, useState } from "react";
import { beginDrag, type Box, side, type SliceView, toScreen, toSlice, viewAt } from "./box";
import type { VolumeCanvas } from "./VolumeCanvas";
import classes from "./box.module.css";

interface BoxLayerProps {
  canvas: VolumeCanvas;
  box: Box;
  /** Where the crosshair is, RAS mm. */
  at: readonly [number, number, number];
  /** Whether dragging changes the box; else everything goes to the slices. */
  draws: boolean;
  onChange: (box: Box) => void;
}

/** Pixels from a side at which it is taken hold of. */
const NEAR = 8;

/** A box over the slices: solid where the slice cuts it, dashed where it lies before or behind. */
export function BoxLayer({ canvas, box, at, draws, onChange }: BoxLayerProps) {
  const layer = useRef<HTMLDivElement>(null);
  const [views, setViews] = useState<readonly SliceView[]>([]);
  const drag = useRef<{ view: SliceView; move: (to: readonly [number, number]) => Box } | null>(null);
  useEffect(() => canvas.watch(setViews), [canvas]);
  const placeOf = (event: { clientX: number; clientY: number }): [number, number] => {
    const { left = 0, top = 0 } = layer.current?.getBoundingClientRect() ?? {};
    return [event.clientX - left, event.clientY - top];
  };
  const down = (event: PointerEvent<HTMLDivElement>) => {
    const view = viewAt(views, placeOf(event));
    if (!view || event.button !== 0 || !event.isPrimary) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    const near = (NEAR * view.size[0]) / view.width;
    drag.current = { view, move: beginDrag(box, view, toSlice(view, placeOf(event)), near, at[view.through]) };
  };
  const move = (event: PointerEvent<HTMLDivElement>) => {
    if (!drag.current) return;
    onChange(drag.current.move(toSlice(drag.current.view, placeOf(event))));
  };
  const up = () => {
    drag.current = null;
  };
  useEffect(() => {
    const element = layer.current;
    if (!element || !draws) return;
    const wheel = (event: WheelEvent) => {
      const view = viewAt(views, placeOf(event));
      if (!view) return;
      event.preventDefault();
      canvas.step(view.through, event.deltaY < 0 ? 1 : -1);
    };
    element.addEventListener("wheel", wheel, { passive: false });
    return () => element.removeEventListener("wheel", wheel);
  }, [canvas, views, draws]);
  return (
    <div
      ref={layer}
      className={classes.layer}
      data-draws={draws || undefined}
      onPointerDown={down}
      onPointerMove={move}
      onPointerUp={up}
      onPointerCancel={up}
    >
      <svg width="100%" height="100%" aria-hidden="true" data-testid="box">
        {views.map((view) => {
          const [x0, y0] = toScreen(view, [box[view.across], box[view.up]]);
          const [x1, y1] = toScreen(view, [side(box, view.across), side(box, view.up)]);
          const cut = at[view.through] >= box[view.through] && at[view.through] <= side(box, view.through);
          return (
            <rect
              key={view.through}
              className={classes.box}
              data-cut={cut || undefined}
              x={Math.min(x0, x1)}
              y={Math.min(y0, y1)}
              width={Math.abs(x1 - x0)}
              height={Math.abs(y1 - y0)}
            />
          );
        })}
      </svg>
    </div>
  );
}
