/** A ball around all vertices of a frame: x, y and z of its middle, and its radius. */
export type Ball = readonly [x: number, y: number, z: number, radius: number];

export function ballOf(positions: ArrayLike<number>): Ball {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < positions.length; at += 1) {
    const axis = at % 3;
    const value = positions[at] ?? 0;
    if (value < (low[axis] ?? 0)) low[axis] = value;
    if (value > (high[axis] ?? 0)) high[axis] = value;
  }
  const [x = 0, y = 0, z = 0] = low.map((value, axis) => (value + (high[axis] ?? 0)) / 2);
  let most = 0;
  for (let at = 0; at + 2 < positions.length; at += 3) {
    const away =
      ((positions[at] ?? 0) - x) ** 2 + ((positions[at + 1] ?? 0) - y) ** 2 + ((positions[at + 2] ?? 0) - z) ** 2;
    if (away > most) most = away;
  }
  return [x, y, z, Math.sqrt(most)];
}

/** Frames that are spread over so many, the first and the last among them. */
export function spread(frames: number, most: number): number[] {
  const count = Math.min(frames, most);
  return Array.from({ length: count }, (_, index) => Math.round((index * (frames - 1)) / Math.max(count - 1, 1)));
}
