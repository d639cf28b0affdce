/** The order in which the profile `gradient` codes faces and vertices: see api_schema/smc-gradient.md. */
export interface Traversal {
  /** The face across each side; -1 for none. */
  across: Int32Array;
  faceOrder: Int32Array;
  /** The face from which each was found; -1 for the first of a part. */
  parents: Int32Array;
  /** When each face is visited. */
  ranks: Int32Array;
  vertexOrder: Int32Array;
  /** Three vertices a, b, c that predict each as a + b - c, or a alone, or none: then -1. */
  predictors: Int32Array;
}

/** What lies across the sides of faces: those that share an edge follow each other in a ring. */
function acrossSides(faces: ArrayLike<number>, vertices: number): Int32Array {
  const rings = new Map<number, number[]>();
  for (let side = 0; side < faces.length; side += 1) {
    const first = faces[side] as number;
    const second = faces[side % 3 === 2 ? side - 2 : side + 1] as number;
    const key = Math.min(first, second) * vertices + Math.max(first, second);
    const ring = rings.get(key);
    if (ring) ring.push(side);
    else rings.set(key, [side]);
  }
  const across = new Int32Array(faces.length).fill(-1);
  for (const ring of rings.values()) {
    if (ring.length < 2) continue;
    ring.forEach((side, k) => (across[side] = Math.floor((ring[(k + 1) % ring.length] as number) / 3)));
  }
  return across;
}

export function traverse(faces: ArrayLike<number>, vertices: number): Traversal {
  const count = faces.length / 3;
  const across = acrossSides(faces, vertices);
  const faceOrder = new Int32Array(count);
  const parents = new Int32Array(count).fill(-1);
  const vertexOrder = new Int32Array(vertices);
  const predictors = new Int32Array(3 * vertices).fill(-1);
  const seenFace = new Uint8Array(count);
  const seenVertex = new Uint8Array(vertices);
  let [filled, placed, head] = [0, 0, 0];
  const place = (v: number, a: number, b: number, c: number) => {
    if (seenVertex[v]) return;
    seenVertex[v] = 1;
    predictors.set([a, b, c], 3 * v);
    vertexOrder[placed] = v;
    placed += 1;
  };
  const last = () => (placed > 0 ? (vertexOrder[placed - 1] as number) : -1);
  const corner = (face: number, k: number) => faces[3 * face + (k % 3)] as number;
  for (let seed = 0; seed < count; seed += 1) {
    if (seenFace[seed]) continue;
    seenFace[seed] = 1;
    faceOrder[filled] = seed;
    filled += 1;
    for (; head < filled; head += 1) {
      const face = faceOrder[head] as number;
      for (let k = 0; k < 3; k += 1) place(corner(face, k), last(), -1, -1);
      for (let side = 0; side < 3; side += 1) {
        const other = across[3 * face + side] as number;
        if (other < 0 || seenFace[other]) continue;
        seenFace[other] = 1;
        parents[other] = face;
        faceOrder[filled] = other;
        filled += 1;
        for (let k = 0; k < 3; k += 1) {
          place(corner(other, k), corner(face, side), corner(face, side + 1), corner(face, side + 2));
        }
      }
    }
  }
  for (let v = 0; v < vertices; v += 1) place(v, last(), -1, -1);
  const ranks = new Int32Array(count);
  faceOrder.forEach((face, rank) => (ranks[face] = rank));
  return { across, faceOrder, parents, ranks, vertexOrder, predictors };
}

/** Undo the prediction: residuals (n · 3, in coding order) to whole numbers by vertex. */
export function fromResiduals({ vertexOrder, predictors }: Traversal, residuals: Float64Array): Float64Array {
  const values = new Float64Array(residuals.length);
  vertexOrder.forEach((v, k) => {
    const [a = -1, b = -1, c = -1] = predictors.subarray(3 * v, 3 * v + 3);
    for (let axis = 0; axis < 3; axis += 1) {
      const at = (vertex: number) => (vertex < 0 ? 0 : (values[3 * vertex + axis] as number));
      values[3 * v + axis] = (residuals[3 * k + axis] as number) + at(a) + at(b) - at(c);
    }
  });
  return values;
}
