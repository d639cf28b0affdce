/** Who is beside whom: the neighbours of v are `neighbours[starts[v]] … neighbours[starts[v + 1] - 1]`, ascending. */
export interface Graph {
  starts: Int32Array;
  neighbours: Int32Array;
}

/** Two vertices are neighbours if a face has them both. */
export function graphOf(faces: ArrayLike<number>, vertices: number): Graph {
  const starts = new Int32Array(vertices + 1);
  const corner = (face: number, k: number) => faces[3 * face + (k % 3)] ?? 0;
  const count = faces.length / 3;
  for (let face = 0; face < count; face += 1) {
    for (let k = 0; k < 3; k += 1) starts[corner(face, k) + 1] = (starts[corner(face, k) + 1] ?? 0) + 2;
  }
  for (let v = 0; v < vertices; v += 1) starts[v + 1] = (starts[v + 1] ?? 0) + (starts[v] ?? 0);
  const fill = starts.slice();
  const all = new Int32Array(starts[vertices] ?? 0);
  for (let face = 0; face < count; face += 1) {
    for (let k = 0; k < 3; k += 1) {
      const v = corner(face, k);
      for (const other of [corner(face, k + 1), corner(face, k + 2)]) {
        all[fill[v] ?? 0] = other;
        fill[v] = (fill[v] ?? 0) + 1;
      }
    }
  }
  // Each once, ascending, and none beside itself.
  const neighbours: number[] = [];
  const begins = new Int32Array(vertices + 1);
  for (let v = 0; v < vertices; v += 1) {
    let before = -1;
    for (const other of all.subarray(starts[v], starts[v + 1]).sort()) {
      if (other !== before && other !== v) neighbours.push(other);
      before = other;
    }
    begins[v + 1] = neighbours.length;
  }
  return { starts: begins, neighbours: Int32Array.from(neighbours) };
}

/** The graph among some vertices, which are numbered anew in their order. */
export function subgraph(
  { starts, neighbours }: Graph,
  members: Int32Array,
  place: Int32Array,
  labels: Int32Array,
): Graph {
  const begins = new Int32Array(members.length + 1);
  const found: number[] = [];
  members.forEach((v, index) => {
    for (let e = starts[v] ?? 0; e < (starts[v + 1] ?? 0); e += 1) {
      const other = neighbours[e] ?? 0;
      if (labels[other] === labels[v]) found.push(place[other] ?? 0);
    }
    begins[index + 1] = found.length;
  });
  return { starts: begins, neighbours: Int32Array.from(found) };
}
