/** A triangle mesh: x, y and z of each vertex, and three vertices of each face. */
interface Mesh {
  positions: Float32Array;
  faces: Uint32Array;
}

/** Formats that a mesh is written in here, and what each is good for. */
export const MESH_FORMATS = [
  { ending: "stl", label: "STL", says: "for printing" },
  { ending: "obj", label: "OBJ", says: "for modelling" },
] as const;

export type MeshEnding = (typeof MESH_FORMATS)[number]["ending"];

/** A mesh as a file. */
export function meshFile(mesh: Mesh, ending: MeshEnding): Blob {
  return ending === "stl" ? stl(mesh) : obj(mesh);
}

/** Binary STL: 80 bytes, the count, and for each face its normal, its corners and two bytes of nothing. */
function stl({ positions, faces }: Mesh): Blob {
  const count = faces.length / 3;
  const view = new DataView(new ArrayBuffer(84 + 50 * count));
  view.setUint32(80, count, true);
  for (let f = 0; f < count; f += 1) {
    const [a = [], b = [], c = []] = [0, 1, 2].map((k) => {
      const at = 3 * (faces[3 * f + k] ?? 0);
      return [...positions.subarray(at, at + 3)];
    });
    const [ux = 0, uy = 0, uz = 0] = b.map((value, axis) => value - (a[axis] ?? 0));
    const [vx = 0, vy = 0, vz = 0] = c.map((value, axis) => value - (a[axis] ?? 0));
    const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const length = Math.hypot(...normal) || 1;
    [...normal.map((value) => value / length), ...a, ...b, ...c].forEach((value, k) =>
      view.setFloat32(84 + 50 * f + 4 * k, value, true),
    );
  }
  return new Blob([view], { type: "model/stl" });
}

/** Wavefront OBJ; vertices keep their order, and all digits that single precision has. */
function obj({ positions, faces }: Mesh): Blob {
  const lines: string[] = [];
  for (let at = 0; at < positions.length; at += 3) {
    lines.push(`v ${[...positions.subarray(at, at + 3)].map((value) => Number(value.toPrecision(9))).join(" ")}\n`);
  }
  for (let at = 0; at < faces.length; at += 3) {
    lines.push(`f ${[...faces.subarray(at, at + 3)].map((vertex) => vertex + 1).join(" ")}\n`);
  }
  return new Blob(lines, { type: "model/obj" });
}
