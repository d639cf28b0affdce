import { describe, expect, it } from "vitest";
import { Brush, paintedParts } from "@/viewers/shape/brush";
import { colorLaid } from "@/features/shapes/coloring";
import { cssColor, matchedColors, partColor, UNMATCHED } from "@/viewers/shape/colors";
import { readGlb, type ShapeMesh } from "@/viewers/shape/glb";
import { graphOf } from "@/viewers/shape/graph";
import { modelOf } from "@/viewers/shape/model";
import { cornerNormals, faceParts, type Pose, partCenters, placed, surfaceOf, UPRIGHT } from "@/viewers/shape/surface";
import { type Turn, ViewLink } from "@/viewers/shape/ViewLink";

/** A box with its faces cut into triangles, turned and moved; one corner is pulled out, so that each axis has a heavier side. */
function box(size: readonly [number, number, number], turn = 0.7, move = 5): ShapeMesh {
  const points: number[] = [];
  for (let v = 0; v < 8; v += 1) {
    const far = v === 7 ? 1.3 : 1;
    const [x, y, z] = [0, 1, 2].map((k) => (v & (1 << k) ? far : -1) * ((size[k] as number) / 2)) as [
      number,
      number,
      number,
    ];
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    const [a, b] = [c * x - s * y, s * x + c * y];
    points.push(a + move, c * b - s * z, s * b + c * z);
  }
  const quads = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
  ] as const;
  return {
    positions: new Float32Array(points),
    faces: new Uint32Array(quads.flatMap(([a, b, c, d]) => [a, b, c, a, c, d])),
  };
}

const LYING: Pose["frame"] = [
  [0, 1, 0],
  [0, 0, 1],
  [1, 0, 0],
];

/** A flat strip of squares along x, each of two faces. */
function strip(length: number): ShapeMesh {
  const positions: number[] = [];
  const faces: number[] = [];
  for (let i = 0; i <= length; i += 1) positions.push(i, 0, 0, i, 1, 0);
  for (let i = 0; i < length; i += 1) {
    const v = 2 * i;
    faces.push(v, v + 2, v + 3, v, v + 3, v + 1);
  }
  return { positions: new Float32Array(positions), faces: new Uint32Array(faces) };
}

function glb({ positions, faces }: ShapeMesh): ArrayBuffer {
  const document = {
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: positions.length / 3, type: "VEC3" },
      { bufferView: 1, componentType: 5125, count: faces.length, type: "SCALAR" },
    ],
    bufferViews: [{ byteOffset: 0 }, { byteOffset: positions.byteLength }],
  };
  const text = new TextEncoder().encode(JSON.stringify(document));
  const padded = Math.ceil(text.length / 4) * 4;
  const binary = positions.byteLength + faces.byteLength;
  const content = new Uint8Array(28 + padded + binary).fill(32);
  const view = new DataView(content.buffer);
  [0x46546c67, 2, content.length, padded, 0x4e4f534a].forEach((word, i) => view.setUint32(4 * i, word, true));
  content.set(text, 20);
  view.setUint32(20 + padded, binary, true);
  view.setUint32(24 + padded, 0x004e4942, true);
  content.set(new Uint8Array(positions.buffer), 28 + padded);
  content.set(new Uint8Array(faces.buffer), 28 + padded + positions.byteLength);
  return content.buffer;
}

const extent = ({ positions }: ShapeMesh) =>
  [0, 1, 2].map((axis) => {
    const values = [...positions].filter((_, i) => i % 3 === axis);
    return Math.max(...values) - Math.min(...values);
  });

describe("glb", () => {
  it("is read as it was written", () => {
    const mesh = box([3, 2, 1]);
    expect(readGlb(glb(mesh))).toEqual(mesh);
  });

  it("is refused where it is something else", () => {
    expect(() => readGlb(new TextEncoder().encode("solid of another kind entirely").buffer)).toThrow("no binary glTF");
  });
});

describe("a shape as it stands", () => {
  it("has the axes of its pose along x, y and z, and fits a ball of radius 1", () => {
    const mesh = box([3, 2, 1], 0, 40);
    const upright = placed(mesh, UPRIGHT.frame);
    const lying = placed(mesh, LYING);
    const [width, height, depth] = extent(upright) as [number, number, number];
    expect(width).toBeGreaterThan(height);
    expect(height).toBeGreaterThan(depth);
    [height, depth, width].forEach((size, axis) => expect(extent(lying)[axis]).toBeCloseTo(size, 5));
    const radii = [...Array(8).keys()].map((v) => Math.hypot(...lying.positions.slice(3 * v, 3 * v + 3)));
    expect(Math.max(...radii)).toBeCloseTo(1, 6);
  });

  it("keeps left and right", () => {
    const mesh = box([3, 2, 1]);
    const mirrored = { ...mesh, positions: mesh.positions.map((value, i) => (i % 3 === 0 ? -value : value)) };
    const volume = ({ positions, faces }: ShapeMesh) => {
      let sum = 0;
      for (let f = 0; f < faces.length; f += 3) {
        const [a, b, c] = [0, 1, 2].map((k) =>
          [0, 1, 2].map((i) => positions[3 * (faces[f + k] as number) + i] as number),
        );
        if (!a || !b || !c) continue;
        const [a0, a1, a2] = a as [number, number, number];
        const [b0, b1, b2] = b as [number, number, number];
        const [c0, c1, c2] = c as [number, number, number];
        sum += a0 * (b1 * c2 - b2 * c1) - a1 * (b0 * c2 - b2 * c0) + a2 * (b0 * c1 - b1 * c0);
      }
      return Math.sign(sum);
    };
    expect(volume(placed(mesh, LYING))).toBe(volume(mesh));
    expect(volume(placed(mirrored, LYING))).toBe(volume(mirrored));
    expect(volume(mirrored)).toBe(-volume(mesh));
  });
});

describe("surface", () => {
  it("measures", () => {
    expect(surfaceOf(strip(4)).area).toBeCloseTo(4, 6);
  });

  it("keeps sharp edges sharp, and round ones round", () => {
    const normals = cornerNormals(box([2, 2, 2], 0, 0));
    // each corner's normal is that of its own face: the edges bend by about 90 degrees
    for (let f = 0; f < 12; f += 1) {
      for (let k = 1; k < 3; k += 1) {
        const dot = [0, 1, 2].reduce(
          (sum, i) => sum + (normals[9 * f + i] as number) * (normals[9 * f + 3 * k + i] as number),
          0,
        );
        expect(dot).toBeGreaterThan(0.9);
      }
    }
    expect([...cornerNormals(strip(2))].filter((_, i) => i % 3 === 2)).toEqual(Array(12).fill(1));
  });

  it("gives each face the part of most of its corners", () => {
    const faces = new Uint32Array([0, 1, 2, 2, 1, 0, 0, 1, 3]);
    expect([...faceParts(faces, [4, 5, 5, 6])]).toEqual([5, 5, 4]);
  });

  it("puts a part's center onto one of its own faces", () => {
    const surface = surfaceOf(strip(6));
    const parts = Int32Array.from([...Array(12).keys()], (f) => (f < 4 || f >= 8 ? 0 : 1));
    const [ends, middle, none] = partCenters(surface, parts, 3);
    expect(none).toBeNull();
    expect(Math.abs((middle?.[0] ?? 0) - 3)).toBeLessThan(1);
    expect((ends?.[0] ?? 3) < 2 || (ends?.[0] ?? 3) > 4).toBe(true); // not in the gap between its two pieces
  });
});

describe("brush", () => {
  it("paints what lies within its reach and hangs together", () => {
    const first = strip(10);
    // a second strip, a little above the first: near, but another piece
    const second = strip(10);
    const both = {
      positions: new Float32Array([...first.positions, ...second.positions.map((v, i) => (i % 3 === 2 ? 0.01 : v))]),
      faces: new Uint32Array([...first.faces, ...second.faces.map((v) => v + 22)]),
    };
    const brush = new Brush(surfaceOf(both));
    expect(brush.stroke(8, [4.5, 0.5, 0], 1.2, false)).toBe(true);
    expect([...brush.painted].sort((a, b) => a - b)).toEqual([6, 7, 8, 9, 10, 11]);
    expect(brush.stroke(8, [4.5, 0.5, 0], 1.2, false)).toBe(false);
    brush.stroke(8, [4.5, 0.5, 0], 0.01, true);
    expect(brush.painted.has(8)).toBe(false);
    brush.clear();
    expect(brush.painted.size).toBe(0);
  });

  it("tells how much is painted, and the parts that it stands for", () => {
    const surface = surfaceOf(strip(10));
    const parts = Int32Array.from([...Array(20).keys()], (f) => Math.floor(f / 4));
    expect(paintedParts(surface, parts, new Set())).toEqual({ share: 0, parts: [], used: 0 });
    const some = paintedParts(surface, parts, new Set([0, 1, 2, 4, 8, 9]));
    expect(some.share).toBeCloseTo(6 / 20, 6);
    expect(some.parts).toEqual([0, 2]);
    expect(some.used).toBeCloseTo(8 / 20, 6);
    // less than half of any: the fullest one
    expect(paintedParts(surface, parts, new Set([13])).parts).toEqual([3]);
  });
});

describe("colors", () => {
  it("are shared by what was matched, and differ between neighbours", () => {
    const { query, found } = matchedColors([
      { query: 0, found: 4, weight: 0.2 },
      { query: 1, found: 4, weight: 0.3 },
      { query: 2, found: 5, weight: 0.1 },
    ]);
    expect(found.get(4)).toEqual(query.get(1));
    expect(found.get(5)).toEqual(query.get(2));
    expect(query.get(0)).toEqual(partColor(0));
    expect(found.has(0)).toBe(false);
    expect(new Set([...Array(40).keys()].map((part) => cssColor(partColor(part)))).size).toBe(40);
  });
});

describe("model and graph", () => {
  const mesh = strip(4);
  const half = [...Array(10).keys()].map((v) => (v < 5 ? 0 : 1));
  const quarter = [...Array(10).keys()].map((v) => Math.min(3, Math.floor(v / 2)));
  const model = modelOf(glb(mesh), {
    vertices: 10,
    levels: [
      { level: 0, labels: Array(10).fill(0) as number[] },
      { level: 1, labels: half },
      { level: 2, labels: quarter },
    ],
  });
  const levels = [
    { level: 0, masses: [1], parents: [], edges: [] },
    { level: 1, masses: [0.5, 0.5], parents: [0, 0], edges: [[0, 1]] },
    { level: 2, masses: [0.25, 0.25, 0.25, 0.25, 0], parents: [0, 0, 1, 1, 1], edges: [[0, 1], [1, 2], [2, 3], [3, 4]] }, // prettier-ignore
  ];

  it("refuses parts of another mesh", () => {
    expect(() => modelOf(glb(mesh), { vertices: 9, levels: [] })).toThrow("do not fit together");
  });

  it("shows the query's parts where they lie on a found shape, and gray where none does", () => {
    const other = strip(2);
    const components = { vertices: 6, levels: [{ level: 0, labels: Array(6).fill(0) as number[] }] };
    const found = modelOf(glb(other), { ...components, cells: [0, 0, 1, 1, 2, 2] });
    const colors = colorLaid(found, [3, 0, -1], model, 1, UNMATCHED) as Float32Array;
    const { faces } = found.surface;
    faces.forEach((vertex, i) => {
      // part 3 lies in part 1 of the coarser level, part 0 in part 0
      const expected = [partColor(1), partColor(0), UNMATCHED][Math.floor(vertex / 2)] as readonly number[];
      expect([...colors.subarray(3 * i, 3 * i + 3)]).toEqual([...new Float32Array(expected)]);
    });
    expect(colorLaid(modelOf(glb(other), components), [3, 0, -1], model, 1, UNMATCHED)).toBeNull();
    expect(colorLaid(found, [], model, 1, UNMATCHED)).toBeNull();
  });

  it("stands as it was told, and where nothing was told, with its y axis up", () => {
    const content = glb(box([3, 2, 1], 0));
    const told = modelOf(content, { vertices: 8, pose: { frame: LYING, towards: [0, 0.6, 0.8] }, levels: [] });
    expect(told.towards).toEqual([0, 0.6, 0.8]);
    const [height, , width] = extent(told.surface) as [number, number, number];
    expect(width).toBeGreaterThan(height);
    const [across, up] = extent(modelOf(content, { vertices: 8, levels: [] }).surface) as [number, number];
    expect(across).toBeGreaterThan(up);
  });

  it("ties each part to its neighbours and to the one that holds it", () => {
    const graph = graphOf(model, levels, 2);
    expect(graph.nodes).toHaveLength(2 + 4); // the fifth part has no face, so it is nowhere
    expect(graph.neighbours).toHaveLength(3);
    expect(graph.parents).toHaveLength(4);
    const xs = graph.nodes.map(({ at }) => at[0]);
    const order = Math.sign((xs[5] ?? 0) - (xs[2] ?? 0));
    for (const [from, to] of graph.neighbours) expect(Math.sign((xs[to] ?? 0) - (xs[from] ?? 0))).toBe(order);
    for (const [part, parent] of graph.parents) expect(Math.abs((xs[part] ?? 9) - (xs[parent] ?? 0))).toBeLessThan(0.5);
    expect(graphOf(model, levels, 7).nodes).toEqual([]);
  });
});

describe("linked views", () => {
  it("turn together, each from where it began", () => {
    const view = () => {
      const made = {
        turn: { around: 0, down: 0, away: 1 },
        follow: (turn: Turn) => {
          made.turn = { ...turn };
        },
      };
      return made;
    };
    const link = new ViewLink();
    const [one, two, three] = [view(), view(), view()] as const;
    link.join(one);
    one.turn = { around: 0.5, down: 0.1, away: 2 };
    link.join(two);
    expect(two.turn).toEqual(one.turn);
    link.join(three);
    link.leave(three);
    two.turn = { around: -1, down: 0, away: 1 };
    link.moved(two);
    expect(one.turn.around).toBe(-1);
    expect(three.turn.around).toBe(0.5);
  });
});
