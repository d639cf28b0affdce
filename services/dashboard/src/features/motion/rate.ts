export interface RatePoint {
  kg: number;
  bits: number;
}

/** The bits at a KG error: between two points as powers go, beyond the last ones as between them; null if unknown. */
export function rateAt(curve: readonly RatePoint[], kg: number): number | null {
  const points = curve.filter((point) => point.kg > 0 && point.bits > 0).sort((one, two) => one.kg - two.kg);
  if (points.length < 2 || !(kg > 0)) return null;
  const right = Math.min(
    Math.max(
      points.findIndex((point) => point.kg >= kg),
      1,
    ),
    points.length - 1,
  );
  const index = points.every((point) => point.kg < kg) ? points.length - 1 : right;
  const [a, b] = [points[index - 1], points[index]];
  if (!a || !b || a.kg === b.kg) return null;
  const slope = Math.log(b.bits / a.bits) / Math.log(b.kg / a.kg);
  return a.bits * (kg / a.kg) ** slope;
}
