/** Colors for signed distances: blue inside, white on the border, red outside. */

const INSIDE = [45, 110, 235];
const MIDDLE = [245, 245, 245];
const OUTSIDE = [228, 62, 62];
const ENDS = [0.5, 1, 2, 3, 5, 10, 20, 50, 100];

export interface Spread {
  /** Of the distances regardless of side, in mm. */
  mean: number;
  within95: number;
  largest: number;
  /** The distance that has the last color: a round number that nearly all lie below. */
  end: number;
}

export function spreadOf(distances: readonly Float32Array[]): Spread {
  const all = Float32Array.from(distances.flatMap((some) => [...some]).map(Math.abs)).sort();
  const mean = all.reduce((sum, value) => sum + value, 0) / Math.max(all.length, 1);
  const within95 = all[Math.max(Math.ceil(0.95 * all.length) - 1, 0)] ?? 0;
  return { mean, within95, largest: all.at(-1) ?? 0, end: ENDS.find((end) => end >= within95) ?? 200 };
}

/** Red, green and blue of each distance, in [0, 1]. */
export function distanceColors(distances: Float32Array, end: number): Float32Array {
  const colors = new Float32Array(3 * distances.length);
  distances.forEach((distance, index) => {
    const share = Math.min(Math.abs(distance) / end, 1);
    const far = distance < 0 ? INSIDE : OUTSIDE;
    for (let channel = 0; channel < 3; channel += 1) {
      const middle = MIDDLE[channel] ?? 0;
      colors[3 * index + channel] = linear((middle + share * ((far[channel] ?? 0) - middle)) / 255);
    }
  });
  return colors;
}

/** The same scale as a gradient in CSS, from `end` inside to `end` outside. */
export const GRADIENT = `linear-gradient(to right, ${[INSIDE, MIDDLE, OUTSIDE].map((color) => `rgb(${color.join(" ")})`).join(", ")})`;

/** Colors of vertices are given to three as light, not as a screen's numbers. */
function linear(value: number): number {
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}
