/**
 * Whether only front faces of a mesh are ever seen from outside: its faces have no border, as chains of directed edges,
 * and each connected part encloses a positive volume, so that its faces are turned outwards. O(faces).
 */
export function isSolid(positions: Float32Array, faces: Uint32Array): boolean {
  const vertices = positions.length / 3;
  return !hasBorder(vertices, faces) && facesOutwards(positions, faces);
}

/** Calls back with both ends of each directed edge of each face. */
function forEachEdge(faces: Uint32Array, told: (from: number, to: number) => void): void {
  for (let at = 0; at < faces.length; at += 3) {
    const [a, b, c] = [faces[at] as number, faces[at + 1] as number, faces[at + 2] as number];
    told(a, b);
    told(b, c);
    told(c, a);
  }
}

/** Whether some edge is not run through as often in one direction as in the other. */
function hasBorder(vertices: number, faces: Uint32Array): boolean {
  // The edges of each vertex to those with higher numbers, one after the other, with their directions.
  const ends = new Uint32Array(vertices + 1);
  forEachEdge(faces, (from, to) => {
    ends[Math.min(from, to)] = (ends[Math.min(from, to)] as number) + 1;
  });
  let sum = 0;
  for (let v = 0; v <= vertices; v += 1) {
    sum += ends[v] as number;
    ends[v] = sum;
  }
  const others = new Uint32Array(faces.length);
  const directions = new Int8Array(faces.length);
  forEachEdge(faces, (from, to) => {
    const low = Math.min(from, to);
    const at = (ends[low] as number) - 1;
    ends[low] = at;
    others[at] = Math.max(from, to);
    directions[at] = Math.sign(to - from);
  });
  for (let v = 0; v < vertices; v += 1) {
    const end = ends[v + 1] as number;
    for (let one = ends[v] as number; one < end; one += 1) {
      let balance = 0;
      for (let other = ends[v] as number; other < end; other += 1) {
        if (others[other] === others[one]) balance += directions[other] as number;
      }
      if (balance !== 0) return true;
    }
  }
  return false;
}

/** Whether each connected part has a positive volume, by the divergence theorem. */
function facesOutwards(positions: Float32Array, faces: Uint32Array): boolean {
  const parents = Uint32Array.from({ length: positions.length / 3 }, (_, v) => v);
  const root = (vertex: number) => {
    let v = vertex;
    for (let up = parents[v] as number; up !== v; up = parents[v] as number) {
      parents[v] = parents[up] as number;
      v = up;
    }
    return v;
  };
  forEachEdge(faces, (from, to) => {
    parents[root(from)] = root(to);
  });
  const volumes = new Float64Array(parents.length);
  const at = (v: number, axis: number, origin: number) =>
    (positions[3 * v + axis] as number) - (positions[3 * origin + axis] as number);
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [faces[f] as number, faces[f + 1] as number, faces[f + 2] as number];
    const o = root(a); // a corner of the part: numbers stay small far from the origin
    const [ax, ay, az] = [at(a, 0, o), at(a, 1, o), at(a, 2, o)];
    const [bx, by, bz] = [at(b, 0, o), at(b, 1, o), at(b, 2, o)];
    const [cx, cy, cz] = [at(c, 0, o), at(c, 1, o), at(c, 2, o)];
    const sixfold = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
    volumes[o] = (volumes[o] as number) + sixfold;
  }
  for (let f = 0; f < faces.length; f += 3) {
    if (!((volumes[root(faces[f] as number)] as number) > 0)) return false;
  }
  return faces.length > 0;
}
