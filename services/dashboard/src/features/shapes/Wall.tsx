import { Checkbox } from "@mantine/core";
import { Link } from "@tanstack/react-router";
import { type ReactNode, useLayoutEffect, useRef, useState } from "react";
import type { Shape } from "@/api/types";
import { GAP, type Grid, layOut, visibleRows } from "./grid";
import { ShapePicture } from "./ShapePicture";
import classes from "./shapes.module.css";

interface WallProps {
  shapes: readonly Shape[];
  /** Whether there are more; asked for before the end comes into view. */
  more: boolean;
  onMore: () => void;
  /** Ids that are ticked; null while nothing can be ticked. */
  chosen: ReadonlySet<string> | null;
  onChoose: (id: string, on: boolean) => void;
}

/** A wall of pictures. Only those in sight are in the page, so that ten thousand scroll as smoothly as ten. */
export function Wall({ shapes, more, onMore, chosen, onChoose }: WallProps) {
  const list = useRef<HTMLUListElement>(null);
  const { grid, first, last } = useRows(list, shapes.length);
  const begin = grid ? first * grid.columns : 0;
  const rows = grid ? Math.ceil(shapes.length / grid.columns) : 0;
  const near = grid !== null && more && last >= rows - 2;
  useLayoutEffect(() => {
    if (near) onMore();
  }, [near, onMore, shapes.length]);
  return (
    <ul
      ref={list}
      className={classes.wall}
      aria-label="Shapes"
      style={{ height: grid ? rows * grid.pitch : undefined }}
      data-testid="wall"
    >
      {grid &&
        shapes.slice(begin, last * grid.columns).map((shape, index) => {
          const at = begin + index;
          return (
            <li
              key={shape.id}
              data-shape={shape.name}
              aria-setsize={more ? -1 : shapes.length}
              aria-posinset={at + 1}
              style={{
                width: grid.side,
                transform: `translate(${(at % grid.columns) * (grid.side + GAP)}px, ${Math.floor(at / grid.columns) * grid.pitch}px)`,
              }}
            >
              <Card shape={shape} side={grid.side} chosen={chosen} onChoose={onChoose} />
            </li>
          );
        })}
    </ul>
  );
}

function Card({
  shape,
  side,
  chosen,
  onChoose,
}: { shape: Shape; side: number } & Pick<WallProps, "chosen" | "onChoose">) {
  const name = shape.name || "Without a name";
  const told = (
    <>
      <ShapePicture shape={shape} size={side} />
      <span className={classes.name} title={name}>
        {name}
      </span>
      <Labels shape={shape} />
    </>
  );
  if (chosen) {
    return (
      <label className={classes.card} data-chosen={chosen.has(shape.id) || undefined}>
        <Checkbox
          className={classes.tick ?? ""}
          aria-label={`Choose ${name}`}
          checked={chosen.has(shape.id)}
          onChange={(event) => onChoose(shape.id, event.currentTarget.checked)}
        />
        {told}
      </label>
    );
  }
  return (
    <Link to="/shapes/$shapeId" params={{ shapeId: shape.id }} className={classes.card} preload={false}>
      {told}
    </Link>
  );
}

function Labels({ shape }: { shape: Shape }): ReactNode {
  const values = Object.values(shape.labels).filter(Boolean);
  return (
    <span className={classes.labels}>
      {shape.outdated ? <span className={classes.outdated}>to be indexed again</span> : values.join(" · ")}
    </span>
  );
}

/** Which rows are in sight, as the window scrolls and the wall changes its width. */
function useRows(list: React.RefObject<HTMLUListElement | null>, count: number) {
  const [seen, setSeen] = useState<{ grid: Grid | null; first: number; last: number }>({
    grid: null,
    first: 0,
    last: 0,
  });
  useLayoutEffect(() => {
    const element = list.current;
    if (!element) return;
    let request = 0;
    const look = () => {
      request = 0;
      const { top, width } = element.getBoundingClientRect();
      const grid = layOut(width);
      const [first, last] = visibleRows(grid, count, Math.max(0, -top), window.innerHeight);
      setSeen((before) =>
        before.first === first &&
        before.last === last &&
        before.grid?.side === grid.side &&
        before.grid.columns === grid.columns
          ? before
          : { grid, first, last },
      );
    };
    const later = () => {
      request ||= requestAnimationFrame(look);
    };
    look();
    const resize = new ResizeObserver(later);
    resize.observe(element);
    window.addEventListener("scroll", later, { passive: true });
    window.addEventListener("resize", later);
    return () => {
      cancelAnimationFrame(request);
      resize.disconnect();
      window.removeEventListener("scroll", later);
      window.removeEventListener("resize", later);
    };
  }, [list, count]);
  return seen;
}
