/** A volume in memory: x runs fastest. */
export interface Grid<T extends Samples> {
  samples: T;
  extent: [number, number, number];
  /** From voxels to mm, row by row. */
  affine: number[][];
}

export type Samples = Uint8Array | Uint16Array | Int16Array | Uint32Array | Int32Array | Float32Array | Float64Array;

/** An axis of fewer voxels is not halved. */
const FEW = 128;

/** Halve the resolution until there are no more than `most` voxels. */
export function reduced<T extends Samples>(grid: Grid<T>, most: number): Grid<T> {
  const [nx, ny, nz] = grid.extent;
  return nx * ny * nz <= most || Math.max(nx, ny, nz) <= FEW ? grid : reduced(halved(grid), most);
}

/** Halve the resolution along each long axis, each voxel the mean of those that it takes the place of. */
export function halved<T extends Samples>({ samples, extent, affine }: Grid<T>): Grid<T> {
  const steps = extent.map((length) => (length > FEW ? 2 : 1)) as [number, number, number];
  const [sx, sy, sz] = steps;
  const [nx, ny] = extent;
  const smaller = extent.map((length, axis) => Math.floor(length / (steps[axis] ?? 1))) as [number, number, number];
  const [mx, my, mz] = smaller;
  const whole = !(samples instanceof Float32Array || samples instanceof Float64Array);
  const result = new (samples.constructor as new (length: number) => T)(mx * my * mz);
  const count = sx * sy * sz;
  for (let z = 0, to = 0; z < mz; z += 1) {
    for (let y = 0; y < my; y += 1) {
      for (let x = 0; x < mx; x += 1, to += 1) {
        let sum = 0;
        for (let dz = 0; dz < sz; dz += 1) {
          for (let dy = 0; dy < sy; dy += 1) {
            const from = ((z * sz + dz) * ny + y * sy + dy) * nx + x * sx;
            for (let dx = 0; dx < sx; dx += 1) sum += samples[from + dx] as number;
          }
        }
        result[to] = whole ? Math.round(sum / count) : sum / count;
      }
    }
  }
  // A new voxel's center lies between those of the old ones.
  const moved = affine.slice(0, 3).map((row) => {
    const shift = steps.reduce((sum, step, axis) => sum + (row[axis] ?? 0) * ((step - 1) / 2), row[3] ?? 0);
    return [...steps.map((step, axis) => (row[axis] ?? 0) * step), shift];
  });
  return { samples: result, extent: smaller, affine: [...moved, [0, 0, 0, 1]] };
}
