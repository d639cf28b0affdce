/** A box as its low corner and its high one: x, y, z, x, y, z in RAS mm. */
export type Box = readonly [number, number, number, number, number, number];
type Axis = 0 | 1 | 2;
type Pair = readonly [number, number];

/** Where a slice is drawn on the canvas, and what of it: places in CSS pixels, lengths in RAS mm. */
export interface SliceView {
  /** The axes that go across, upwards, and through the slice. */
  across: Axis;
  up: Axis;
  through: Axis;
  left: number;
  top: number;
  width: number;
  height: number;
  /** Across from the right to the left. */
  mirrored: boolean;
  /** What is at the lower end of both axes, and how long they are. */
  low: Pair;
  size: Pair;
}

/** Where a point of a slice is seen. */
export function toScreen({ left, top, width, height, mirrored, low, size }: SliceView, [across, up]: Pair): Pair {
  const along = (across - low[0]) / size[0];
  return [left + (mirrored ? 1 - along : along) * width, top + (1 - (up - low[1]) / size[1]) * height];
}

/** The point of a slice that is seen at a place, kept within the slice. */
export function toSlice({ left, top, width, height, mirrored, low, size }: SliceView, [x, y]: Pair): Pair {
  const within = (share: number) => Math.min(Math.max(share, 0), 1);
  const along = within((x - left) / width);
  return [low[0] + (mirrored ? 1 - along : along) * size[0], low[1] + within(1 - (y - top) / height) * size[1]];
}

export function viewAt(views: readonly SliceView[], [x, y]: Pair): SliceView | undefined {
  return views.find(({ left, top, width, height }) => x >= left && x < left + width && y >= top && y < top + height);
}

/** A box of some length around a point. */
export function around(point: readonly [number, number, number], length: number): Box {
  const [x, y, z] = point;
  const half = length / 2;
  return [x - half, y - half, z - half, x + half, y + half, z + half];
}

/**
 * Begin to drag in a slice at `from`: near a side of the box (`near` in mm) that side goes with the pointer, inside of it
 * the whole box, and elsewhere a new one is drawn, which keeps its depth where the slice, at `plane`, cuts it.
 */
export function beginDrag(box: Box, view: SliceView, from: Pair, near: number, plane: number): (to: Pair) => Box {
  const axes = [view.across, view.up] as const;
  const sides = axes.map((axis, k) => {
    const [low, high, at] = [box[axis], side(box, axis), from[k] as number];
    if (at < low - near || at > high + near) return "out";
    if (Math.abs(at - low) <= near) return "low";
    return Math.abs(at - high) <= near ? "high" : "in";
  });
  const out = sides.includes("out") || plane < box[view.through] || plane > side(box, view.through);
  return (to) => {
    const next = [...box] as [number, number, number, number, number, number];
    axes.forEach((axis, k) => {
      const [begin, end] = [from[k] as number, to[k] as number];
      let [low, high] = [box[axis], side(box, axis)];
      if (out) [low, high] = [begin, end];
      else if (sides[k] === "low") low = end;
      else if (sides[k] === "high") high = end;
      else if (!sides.some((one) => one === "low" || one === "high"))
        [low, high] = [low + end - begin, high + end - begin];
      [next[axis], next[axis + 3]] = [Math.min(low, high), Math.max(low, high)];
    });
    const { through } = view;
    if (plane < box[through] || plane > side(box, through)) {
      const depth = axes.reduce<number>((sum, axis) => sum + side(next, axis) - next[axis], 0) / 4;
      [next[through], next[through + 3]] = [plane - depth, plane + depth];
    }
    return next;
  };
}

/** The high end along an axis. */
export function side(box: Box, axis: Axis): number {
  return box[axis + 3] as number;
}
