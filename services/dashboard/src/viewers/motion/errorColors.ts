/** From no error to the largest: readable without telling red from green, and on black. */
const STOPS: readonly (readonly [number, number, number])[] = [
  [0.22, 0.42, 0.66],
  [0.35, 0.68, 0.7],
  [0.93, 0.9, 0.72],
  [0.96, 0.62, 0.32],
  [0.82, 0.2, 0.24],
];

/** The color of a share of the largest error, written to `into` at `at`. */
export function errorColor(share: number, into: Float32Array, at: number): void {
  const place = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
  const low = Math.min(Math.floor(place), STOPS.length - 2);
  const part = place - low;
  for (let channel = 0; channel < 3; channel += 1) {
    const [a, b] = [STOPS[low]?.[channel] ?? 0, STOPS[low + 1]?.[channel] ?? 0];
    // vertex colors are linear light
    into[at + channel] = (a + (b - a) * part) ** 2.2;
  }
}

export const ERROR_GRADIENT = `linear-gradient(90deg, ${STOPS.map(
  (stop) => `rgb(${stop.map((value) => Math.round(255 * value)).join(" ")})`,
).join(", ")})`;
