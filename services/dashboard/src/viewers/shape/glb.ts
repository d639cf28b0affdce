/** A mesh as a viewer takes it. */
export interface ShapeMesh {
  /** x, y and z of each vertex. */
  positions: Float32Array;
  /** Three vertices of each face. */
  faces: Uint32Array;
}

interface Document {
  meshes?: { primitives: { attributes: Record<string, number>; indices?: number }[] }[];
  accessors?: { bufferView: number; byteOffset?: number; componentType: number; count: number; type: string }[];
  bufferViews?: { byteOffset?: number; byteStride?: number }[];
}

const [MAGIC, JSON_CHUNK, FLOAT, UNSIGNED] = [0x46546c67, 0x4e4f534a, 5126, 5125];

/**
 * Read the one mesh of a `mesh.glb` in the order of its vertices, which the components refer to by number; in the
 * frame of the file that was uploaded, before the scene turns it for programs that look along another axis.
 */
export function readGlb(content: ArrayBuffer): ShapeMesh {
  const view = new DataView(content);
  if (content.byteLength < 20 || view.getUint32(0, true) !== MAGIC || view.getUint32(16, true) !== JSON_CHUNK) {
    throw new Error("This is no binary glTF.");
  }
  const length = view.getUint32(12, true);
  const document = JSON.parse(new TextDecoder().decode(new Uint8Array(content, 20, length))) as Document;
  const begin = 20 + length + 8;
  const primitive = document.meshes?.[0]?.primitives[0];
  const place = (index: number | undefined, type: string, component: number) => {
    const accessor = index === undefined ? undefined : document.accessors?.[index];
    const part = accessor && document.bufferViews?.[accessor.bufferView];
    if (!accessor || !part || accessor.type !== type || accessor.componentType !== component || part.byteStride) {
      throw new Error("The mesh is laid out in a way that is not read here.");
    }
    return { at: begin + (part.byteOffset ?? 0) + (accessor.byteOffset ?? 0), count: accessor.count };
  };
  const points = place(primitive?.attributes.POSITION, "VEC3", FLOAT);
  const corners = place(primitive?.indices, "SCALAR", UNSIGNED);
  return {
    positions: new Float32Array(content.slice(points.at, points.at + 12 * points.count)),
    faces: new Uint32Array(content.slice(corners.at, corners.at + 4 * corners.count)),
  };
}
