import { describe, expect, it } from "vitest";
import { turnOnto } from "@/viewers/shape/align";
import type { Vector } from "@/viewers/shape/surface";

const POINTS: Vector[] = [
  [0.9, 0.1, 0],
  [-0.4, 0.6, 0.1],
  [0.1, -0.7, 0.3],
  [0, 0.2, -0.8],
  [0.3, 0.3, 0.3],
];

/** A turn about an axis of unit length (Rodrigues). */
function turn([x, y, z]: Vector, axis: Vector, angle: number): Vector {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [a, b, d] = axis;
  const along = (1 - c) * (a * x + b * y + d * z);
  return [c * x + s * (b * z - d * y) + a * along, c * y + s * (d * x - a * z) + b * along, c * z + s * (a * y - b * x) + d * along]; // prettier-ignore
}

describe("laying a found shape like its example", () => {
  it.each([
    [[0, 0, 1], 2.5],
    [[0.6, 0, 0.8], 1.2],
    [[0, -1, 0], 3.1],
  ] as [Vector, number][])("finds the turn about %o by %f", (axis, angle) => {
    const found = turnOnto(POINTS.map((point) => [point, turn(point, axis, angle), 0.5]));
    const sign = Math.sign(found?.[0] ?? 0);
    const expected = [Math.cos(angle / 2), ...axis.map((value) => value * Math.sin(angle / 2))];
    expected.forEach((value, k) => expect(sign * (found?.[k] ?? 9)).toBeCloseTo(value, 5));
  });

  it("leaves what lies well, and what no turn brings nearer", () => {
    expect(turnOnto(POINTS.map((point) => [point, turn(point, [0, 0, 1], 0.3), 1]))).toBeNull();
    const elsewhere = [3, 0, 4, 1, 2].map((k) => POINTS[k] as Vector);
    expect(turnOnto(POINTS.map((point, k) => [point, elsewhere[k] as Vector, 1]))).toBeNull();
  });
});
