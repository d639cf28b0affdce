import { expect, test } from "vitest";
import { isSolid } from "@/viewers/motion/solid";

/** A tetrahedron around a point, turned outwards. */
function tetrahedron(x: number, size: number, first = 0): { positions: number[]; faces: number[] } {
  const corners = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  const positions = corners.flatMap(([a = 0, b = 0, c = 0]) => [x + size * a, size * b, size * c]);
  return { positions, faces: [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3].map((v) => v + first) };
}

const solid = (positions: number[], faces: number[]) => isSolid(new Float32Array(positions), new Uint32Array(faces));
const flipped = (faces: number[]) => faces.map((_, i) => faces[i - (i % 3) + ([0, 2, 1][i % 3] ?? 0)] as number);

test("a closed mesh that is turned outwards is solid, wherever it is", () => {
  for (const x of [0, -5, 1000]) {
    const { positions, faces } = tetrahedron(x, 1);
    expect(solid(positions, faces)).toBe(true);
    expect(solid(positions, flipped(faces))).toBe(false);
  }
});

test("a mesh with a hole, or with a face that is turned around, is not", () => {
  const { positions, faces } = tetrahedron(0, 1);
  expect(solid(positions, faces.slice(3))).toBe(false);
  expect(solid(positions, [...flipped(faces.slice(0, 3)), ...faces.slice(3)])).toBe(false);
  expect(solid([], [])).toBe(false);
});

test("each part counts for itself; vertices that no face has do not", () => {
  const [large, small] = [tetrahedron(0, 9), tetrahedron(20, 1, 4)];
  const positions = [...large.positions, ...small.positions, 1, 2, 3];
  expect(solid(positions, [...large.faces, ...small.faces])).toBe(true);
  expect(solid(positions, [...large.faces, ...flipped(small.faces)])).toBe(false);
  expect(solid(positions, [...large.faces, ...small.faces.slice(3)])).toBe(false);
});
