export type Rgb = readonly [number, number, number];

/** Parts that nothing was matched with, and shapes whose parts are not shown. */
export const PLAIN: Rgb = [0.56, 0.65, 0.68];
export const UNMATCHED: Rgb = [0.34, 0.38, 0.39];
export const PAINT: Rgb = [0.96, 0.66, 0.24];
/** Parts that a painted region stands for, where they are not painted themselves. */
export const TAKEN: Rgb = [0.62, 0.5, 0.33];

/** Colors that neighbouring numbers do not share: the hue turns by the golden ratio, and lightness alternates. */
export function partColor(part: number): Rgb {
  return fromHsl((part * 0.618034 + 0.08) % 1, 0.55, part % 2 === 0 ? 0.66 : 0.54);
}

/** The same as CSS writes it. */
export function cssColor(color: Rgb): string {
  return `rgb(${color.map((channel) => Math.round(channel * 255)).join(" ")})`;
}

export interface Match {
  query: number;
  found: number;
  weight: number;
}

/**
 * Colors of the parts of a query and of a found shape: parts that were put together share one. A found part takes that
 * of the query's part that most of its area was matched with.
 */
export function matchedColors(matches: readonly Match[]): { query: Map<number, Rgb>; found: Map<number, Rgb> } {
  const query = new Map<number, Rgb>();
  const most = new Map<number, Match>();
  for (const match of matches) {
    query.set(match.query, partColor(match.query));
    if (match.weight > (most.get(match.found)?.weight ?? 0)) most.set(match.found, match);
  }
  return { query, found: new Map([...most].map(([found, match]) => [found, partColor(match.query)])) };
}

function fromHsl(hue: number, saturation: number, lightness: number): Rgb {
  const a = saturation * Math.min(lightness, 1 - lightness);
  const channel = (n: number) => {
    const k = (n + hue * 12) % 12;
    return lightness - a * Math.max(-1, Math.min(k - 3, 9 - k, 1));
  };
  return [channel(0), channel(8), channel(4)];
}
