/** How a wall of cards is laid out: square pictures with a caption, as many in a row as there is room for. */
export interface Grid {
  columns: number;
  /** Side of a picture and width of a card. */
  side: number;
  /** From one row's top to the next one's. */
  pitch: number;
}

export const [LEAST, GAP, CAPTION] = [156, 14, 52];

export function layOut(width: number): Grid {
  const columns = Math.max(2, Math.floor((width + GAP) / (LEAST + GAP)));
  const side = Math.max(0, Math.floor((width - GAP * (columns - 1)) / columns));
  return { columns, side, pitch: side + CAPTION + GAP };
}

/** Rows that are seen, with some before and after: from the first up to, not including, the last. */
export function visibleRows(grid: Grid, count: number, above: number, height: number, more = 2): [number, number] {
  const rows = Math.ceil(count / grid.columns);
  const first = Math.floor(above / grid.pitch) - more;
  const last = Math.ceil((above + height) / grid.pitch) + more;
  return [Math.min(Math.max(first, 0), rows), Math.min(Math.max(last, 0), rows)];
}
