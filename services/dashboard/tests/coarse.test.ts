import { describe, expect, it } from "vitest";
import { coarsen } from "@/viewers/coarse";
import { isSolid } from "@/viewers/motion/solid";

/** A ball of `rings` times `rings` quads around its axis, closed at its poles, its faces turned outwards. */
function ball(rings: number, radius = 5, at: readonly [number, number, number] = [0, 0, 0]) {
  const points: number[] = [...at];
  points[2] = at[2] + radius;
  for (let ring = 1; ring < rings; ring += 1) {
    const polar = (Math.PI * ring) / rings;
    for (let k = 0; k < rings; k += 1) {
      const around = (2 * Math.PI * k) / rings;
      points.push(
        at[0] + radius * Math.sin(polar) * Math.cos(around),
        at[1] + radius * Math.sin(polar) * Math.sin(around),
        at[2] + radius * Math.cos(polar),
      );
    }
  }
  points.push(at[0], at[1], at[2] - radius);
  const last = points.length / 3 - 1;
  const faces: number[] = [];
  for (let k = 0; k < rings; k += 1) {
    const next = (k + 1) % rings;
    faces.push(0, 1 + k, 1 + next);
    for (let ring = 0; ring < rings - 2; ring += 1) {
      const [above, below] = [1 + ring * rings, 1 + (ring + 1) * rings];
      faces.push(above + k, below + k, above + next, above + next, below + k, below + next);
    }
    faces.push(last, last - rings + next, last - rings + k);
  }
  return { positions: new Float32Array(points), faces: new Uint32Array(faces) };
}

function volumeOf(positions: Float32Array, faces: Uint32Array): number {
  let sum = 0;
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => positions.subarray(3 * (faces[f + k] ?? 0)));
    const [ax = 0, ay = 0, az = 0] = a ?? [];
    const [bx = 0, by = 0, bz = 0] = b ?? [];
    const [cx = 0, cy = 0, cz = 0] = c ?? [];
    sum += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
  }
  return sum / 6;
}

describe("a coarse mesh", () => {
  const fine = ball(200);

  it("is the mesh itself where that has few faces", () => {
    expect(coarsen(fine, fine.faces.length / 3)).toBeNull();
  });

  it.each([10_000, 1_000, 100, 4])("has at most %i faces, closed and turned as before", (most) => {
    const coarse = coarsen(fine, most);
    if (!coarse) throw new Error("it is as it was");
    const positions = coarse.gather(fine.positions);
    expect(coarse.faces.length).toBeLessThanOrEqual(3 * most);
    if (most < 100) return;
    expect(coarse.faces.length).toBeGreaterThan(1.5 * most); // and not without need fewer
    expect(isSolid(positions, coarse.faces)).toBe(true);
    // As near to the ball as so few faces come: a cell is some sqrt(3 · area / most) wide.
    const cell = Math.sqrt((3 * 4 * Math.PI * 25) / most);
    for (let at = 0; at < positions.length; at += 3) {
      expect(Math.hypot(...positions.subarray(at, at + 3))).toBeGreaterThan(5 - 0.2 * cell * cell);
      expect(Math.hypot(...positions.subarray(at, at + 3))).toBeLessThan(5 + 1e-5);
    }
    if (most >= 1_000)
      expect(volumeOf(positions, coarse.faces) / volumeOf(fine.positions, fine.faces)).toBeGreaterThan(0.95);
  });

  it("joins corners that each face has for itself", () => {
    const soup = new Float32Array([...fine.faces].flatMap((v) => [...fine.positions.subarray(3 * v, 3 * v + 3)]));
    const coarse = coarsen({ positions: soup, faces: fine.faces.map((_, corner) => corner) }, 5_000);
    if (!coarse) throw new Error("it is as it was");
    expect(isSolid(coarse.gather(soup), coarse.faces)).toBe(true);
  });

  it("moves as the mesh does", () => {
    const coarse = coarsen(fine, 2_000);
    const before = coarse?.gather(fine.positions);
    const after = coarse?.gather(fine.positions.map((value, at) => value + (at % 3 === 0 ? 3 : 0)));
    after?.forEach((value, at) => expect(value).toBeCloseTo((before?.[at] ?? 0) + (at % 3 === 0 ? 3 : 0), 4));
  });

  it("is made of what is far away, tiny, flat or broken", () => {
    const far = ball(60, 1e-3, [1e3, -1e3, 0]);
    expect(coarsen(far, 500)?.faces.length).toBeGreaterThan(0);
    const flat = { positions: fine.positions.map((value, at) => (at % 3 === 2 ? 0 : value)), faces: fine.faces };
    expect(coarsen(flat, 500)?.faces.length).toBeGreaterThan(0);
    const line = { positions: fine.positions.map((value, at) => (at % 3 === 0 ? value : 0)), faces: fine.faces };
    expect(coarsen(line, 500)?.faces.length).toBeLessThanOrEqual(1_500);
    const point = { positions: fine.positions.map(() => 7), faces: fine.faces };
    expect(coarsen(point, 500)?.faces.length).toBe(0);
    const broken = { positions: fine.positions.slice(), faces: fine.faces.slice() };
    broken.positions[300] = Number.NaN;
    broken.positions[601] = Number.POSITIVE_INFINITY;
    broken.faces[50] = 4_000_000_000;
    const coarse = coarsen(broken, 2_000);
    expect(coarse?.faces.length).toBeGreaterThan(3_000);
    expect(coarse?.gather(broken.positions).every(Number.isFinite)).toBe(true);
  });
});
