import type { LabelVolume } from "@/format/nifti";
import type { SurfaceMesh } from "@/viewers/surface/readSurface";

/** Red, green, blue and opacity of each pixel, row by row from the top. */
export interface Picture {
  width: number;
  height: number;
  data: Uint8ClampedArray<ArrayBuffer>;
}

/** The slice through the middle of a volume as a radiologist reads it: the face above, the patient's left on the right. */
export function sliceOf({ shape, affine, values }: LabelVolume, size: number): Picture {
  const column = (axis: number) => [0, 1, 2].map((row) => affine[4 * row + axis] ?? 0);
  const share = (axis: number, row: number) => Math.abs(column(axis)[row] ?? 0) / Math.hypot(...column(axis));
  // Which of the file's axes goes up through the body, and which of the others from left to right.
  const axes = [0, 1, 2];
  const through = axes.reduce((best, axis) => (share(axis, 2) > share(best, 2) ? axis : best));
  const [one = 0, other = 1] = axes.filter((axis) => axis !== through);
  const [across, up] = share(one, 0) >= share(other, 0) ? [one, other] : [other, one];
  const leftwards = (column(across)[0] ?? 0) < 0;
  const upwards = (column(up)[1] ?? 0) > 0;
  const strides = [1, shape[0], shape[0] * shape[1]];
  const [nx, ny] = [shape[across as 0], shape[up as 0]];
  const [width, height] = [nx * Math.hypot(...column(across)), ny * Math.hypot(...column(up))];
  const scale = size / Math.max(width, height);
  const [columns, rows] = [Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale))];
  const base = Math.floor((shape[through as 0] ?? 1) / 2) * (strides[through] ?? 1);
  const found = new Float64Array(columns * rows);
  for (let row = 0; row < rows; row += 1) {
    const fromTop = Math.floor(((row + 0.5) / rows) * ny);
    const v = upwards ? ny - 1 - fromTop : fromTop;
    for (let at = 0; at < columns; at += 1) {
      const fromLeft = Math.floor(((at + 0.5) / columns) * nx);
      const u = leftwards ? fromLeft : nx - 1 - fromLeft;
      found[row * columns + at] = Number(values[base + u * (strides[across] ?? 1) + v * (strides[up] ?? 1)]);
    }
  }
  const [black, white] = windowOf(found);
  const data = new Uint8ClampedArray(4 * columns * rows);
  found.forEach((value, index) => {
    const gray = (255 * (value - black)) / (white - black || 1);
    data.set([gray, gray, gray, 255], 4 * index);
  });
  return { width: columns, height: rows, data };
}

/** Black and white of a good first picture: without the hundredth that is darkest, and the one that is brightest. */
function windowOf(values: Float64Array): [number, number] {
  const sorted = values.filter(Number.isFinite).sort();
  const at = (share: number) => sorted[Math.round(share * (sorted.length - 1))] ?? 0;
  return at(0.01) < at(0.99) ? [at(0.01), at(0.99)] : [at(0), at(1)];
}

const COLOR = [143, 201, 196] as const;
/** As the viewers look at a mesh: from the front, a little from the right and above. */
const TOWARDS = unit([0.5, 0.35, 1]);
const RIGHT = unit([TOWARDS[2], 0, -TOWARDS[0]]);
const ABOVE = [
  TOWARDS[1] * RIGHT[2] - TOWARDS[2] * RIGHT[1],
  TOWARDS[2] * RIGHT[0] - TOWARDS[0] * RIGHT[2],
  TOWARDS[0] * RIGHT[1] - TOWARDS[1] * RIGHT[0],
] as const;
const LIGHT = unit([0.35, 0.55, 1]);

/** A mesh drawn without a graphics card: each face by its slope to the light, the nearest in front. */
export function meshPicture({ positions, faces }: SurfaceMesh, size: number): Picture {
  const count = positions.length / 3;
  const seen = new Float32Array(positions.length);
  const low = [Infinity, Infinity];
  const high = [-Infinity, -Infinity];
  for (let v = 0; v < count; v += 1) {
    const [x = 0, y = 0, z = 0] = positions.subarray(3 * v, 3 * v + 3);
    [RIGHT, ABOVE, TOWARDS].forEach((axis, k) => {
      const value = x * axis[0] + y * axis[1] + z * axis[2];
      seen[3 * v + k] = value;
      if (k < 2) {
        low[k] = Math.min(low[k] ?? 0, value);
        high[k] = Math.max(high[k] ?? 0, value);
      }
    });
  }
  const [left = 0, bottom = 0] = low;
  const [width, height] = [(high[0] ?? 0) - left, (high[1] ?? 0) - bottom];
  const scale = (0.92 * size) / (Math.max(width, height) || 1);
  const [shiftX, shiftY] = [(size - scale * width) / 2, (size - scale * height) / 2];
  for (let v = 0; v < count; v += 1) {
    seen[3 * v] = shiftX + scale * ((seen[3 * v] ?? 0) - left);
    seen[3 * v + 1] = size - shiftY - scale * ((seen[3 * v + 1] ?? 0) - bottom);
    seen[3 * v + 2] = scale * (seen[3 * v + 2] ?? 0);
  }
  const data = new Uint8ClampedArray(4 * size * size);
  const depths = new Float32Array(size * size).fill(-Infinity);
  const corner = (index: number) => 3 * (faces[index] ?? 0);
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [corner(f), corner(f + 1), corner(f + 2)];
    const [ax = 0, ay = 0, az = 0] = [seen[a], seen[a + 1], seen[a + 2]];
    const [bx = 0, by = 0, bz = 0] = [seen[b], seen[b + 1], seen[b + 2]];
    const [cx = 0, cy = 0, cz = 0] = [seen[c], seen[c + 1], seen[c + 2]];
    const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    if (!(area !== 0)) continue; // edge on, or a corner that is no number
    const nx = (by - ay) * (cz - az) - (cy - ay) * (bz - az);
    const ny = (bz - az) * (cx - ax) - (cz - az) * (bx - ax);
    const length = Math.hypot(nx, ny, area) || 1;
    // Rows count downwards; both sides are lit alike.
    const lit =
      0.3 + 0.75 * Math.max(0, (Math.sign(area) * (nx * LIGHT[0] - ny * LIGHT[1] + area * LIGHT[2])) / length);
    const [right, down] = [
      Math.min(size - 1, Math.floor(Math.max(ax, bx, cx))),
      Math.min(size - 1, Math.floor(Math.max(ay, by, cy))),
    ];
    for (let row = Math.max(0, Math.floor(Math.min(ay, by, cy))); row <= down; row += 1) {
      for (let at = Math.max(0, Math.floor(Math.min(ax, bx, cx))); at <= right; at += 1) {
        const [x, y] = [at + 0.5, row + 0.5];
        const u = ((bx - x) * (cy - y) - (cx - x) * (by - y)) / area;
        const v = ((cx - x) * (ay - y) - (ax - x) * (cy - y)) / area;
        const depth = u * az + v * bz + (1 - u - v) * cz;
        if (u < 0 || v < 0 || u + v > 1 || depth <= (depths[row * size + at] ?? 0)) continue;
        depths[row * size + at] = depth;
        data.set([COLOR[0] * lit, COLOR[1] * lit, COLOR[2] * lit, 255], 4 * (row * size + at));
      }
    }
  }
  return { width: size, height: size, data };
}

function unit([x, y, z]: readonly [number, number, number]): [number, number, number] {
  const length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}
