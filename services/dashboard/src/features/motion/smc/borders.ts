import type { Graph } from "./graph";

/** What clusters decoded before tell of the vertices beside the next one. */
export interface Beside {
  /** For each vertex of the cluster, how many of its neighbours are in earlier clusters. */
  counts: Float64Array;
  /** rank · vertices: their components by the cluster's functions, on average; 0 where there are none. */
  means: Float64Array;
}

/** A cluster as far as it is decoded. */
export interface Decoded {
  rank: number;
  vertices: number;
  /** rank · vertices, in units of the step. */
  fields: Float64Array;
  /** rank · (frames · 3). */
  rows: Float64Array;
}

const AT_ONCE = 64;

/** Functions of time (frames · rank · 3) with all frames of a mode in a row. */
export function inRows(functions: Float64Array, rank: number): Float64Array {
  const rows = new Float64Array(functions.length);
  const length = rank > 0 ? functions.length / rank : 0;
  for (let mode = 0; mode < rank; mode += 1) {
    for (let t = 0; t < length / 3; t += 1) {
      for (let axis = 0; axis < 3; axis += 1) {
        rows[mode * length + 3 * t + axis] = functions[3 * (t * rank + mode) + axis] as number;
      }
    }
  }
  return rows;
}

/**
 * Express what lies beyond a cluster's border by its own functions: section 5.2 of api_schema/smc.md. Its mean trajectory
 * in steps is taken away first; it is empty where there is none.
 */
export function lookBeyond(
  { starts, neighbours }: Graph,
  members: Int32Array,
  labels: Int32Array,
  place: Int32Array,
  before: readonly Decoded[],
  rank: number,
  rows: Float64Array,
  mean: Float64Array,
): Beside {
  const label = labels[members[0] ?? 0] ?? 0;
  const owners: number[] = [];
  const ends: number[] = [];
  members.forEach((v, index) => {
    for (let e = starts[v] ?? 0; e < (starts[v + 1] ?? 0); e += 1) {
      const other = neighbours[e] as number;
      if ((labels[other] as number) >= label) continue;
      owners.push(index);
      ends.push(other);
    }
  });
  const found = [...new Set(ends)];
  const numbers = new Map(found.map((v, number) => [v, number]));
  const values = new Float64Array(rank * found.length);
  const byCluster = new Map<number, number[]>();
  for (const v of found) {
    const other = labels[v] as number;
    byCluster.set(other, [...(byCluster.get(other) ?? []), v]);
  }
  for (const [other, vertices] of byCluster) {
    const decoded = before[other];
    if (!decoded) continue;
    for (let k = 0; k < vertices.length; k += AT_ONCE) {
      const some = vertices.slice(k, k + AT_ONCE);
      project(
        decoded,
        some.map((v) => place[v] as number),
        mean,
        rank,
        rows,
        some.map((v) => numbers.get(v) as number),
        found.length,
        values,
      );
    }
  }
  const n = members.length;
  const counts = new Float64Array(n);
  const means = new Float64Array(rank * n);
  for (const owner of owners) counts[owner] = (counts[owner] as number) + 1;
  const columns = ends.map((v) => numbers.get(v) as number);
  for (let mode = 0; mode < rank; mode += 1) {
    owners.forEach((owner, e) => {
      const at = mode * n + owner;
      means[at] = (means[at] as number) + (values[mode * found.length + (columns[e] as number)] as number);
    });
    for (let v = 0; v < n; v += 1) {
      if ((counts[v] as number) > 0) means[mode * n + v] = (means[mode * n + v] as number) / (counts[v] as number);
    }
  }
  return { counts, means };
}

/** The components of some vertices' trajectories by each function in turn; what it explains is taken away. */
function project(
  { rank: others, vertices, fields, rows: theirs }: Decoded,
  inside: readonly number[],
  mean: Float64Array,
  rank: number,
  rows: Float64Array,
  columns: readonly number[],
  width: number,
  values: Float64Array,
): void {
  const count = inside.length;
  const length = rank > 0 ? rows.length / rank : 0;
  const rest = new Float64Array(length * count);
  const column = new Float64Array(count);
  for (let mode = 0; mode < others; mode += 1) {
    for (let u = 0; u < count; u += 1) column[u] = fields[mode * vertices + (inside[u] as number)] as number;
    for (let t = 0; t < length; t += 1) {
      const factor = theirs[mode * length + t] as number;
      for (let u = 0, at = t * count; u < count; u += 1, at += 1) {
        rest[at] = (rest[at] as number) + (column[u] as number) * factor;
      }
    }
  }
  mean.forEach((value, t) => {
    for (let u = 0, at = t * count; u < count; u += 1, at += 1) rest[at] = (rest[at] as number) - value;
  });
  for (let mode = 0; mode < rank; mode += 1) {
    column.fill(0);
    for (let t = 0; t < length; t += 1) {
      const factor = rows[mode * length + t] as number;
      for (let u = 0, at = t * count; u < count; u += 1, at += 1) {
        column[u] = (column[u] as number) + (rest[at] as number) * factor;
      }
    }
    for (let t = 0; t < length; t += 1) {
      const factor = rows[mode * length + t] as number;
      for (let u = 0, at = t * count; u < count; u += 1, at += 1) {
        rest[at] = (rest[at] as number) - (column[u] as number) * factor;
      }
    }
    for (let u = 0; u < count; u += 1) values[mode * width + (columns[u] as number)] = column[u] as number;
  }
}
