import { Matrix4, Quaternion, Vector3 } from "three";
import type { SurfaceMesh } from "@/viewers/surface/readSurface";

interface Node {
  mesh?: number;
  children?: number[];
  matrix?: number[];
  translation?: [number, number, number];
  rotation?: [number, number, number, number];
  scale?: [number, number, number];
}

interface Document {
  scene?: number;
  scenes?: { nodes?: number[] }[];
  nodes?: Node[];
  meshes?: { primitives: { attributes: Record<string, number>; indices?: number; mode?: number }[] }[];
  accessors?: {
    bufferView?: number;
    byteOffset?: number;
    componentType: number;
    count: number;
    sparse?: unknown;
  }[];
  bufferViews?: { buffer: number; byteOffset?: number; byteStride?: number }[];
  buffers?: { uri?: string }[];
}

const [MAGIC, TRIANGLES] = [0x46546c67, 4];
const DEEPEST = 64;
const INDEX: Record<number, [number, "getUint8" | "getUint16" | "getUint32"]> = {
  5121: [1, "getUint8"],
  5123: [2, "getUint16"],
  5125: [4, "getUint32"],
};

/** All triangles of a binary glTF 2.0 scene as one mesh; throws a sentence for what is laid out otherwise. */
export function readScene(content: ArrayBuffer): SurfaceMesh {
  const view = new DataView(content);
  if (content.byteLength < 20 || view.getUint32(0, true) !== MAGIC) throw new Error("This is no binary glTF.");
  const length = view.getUint32(12, true);
  const document = JSON.parse(new TextDecoder().decode(new Uint8Array(content, 20, length))) as Document;
  const binary = 20 + length + 8;
  const positions: number[] = [];
  const faces: number[] = [];

  const place = (index: number | undefined) => {
    const accessor = document.accessors?.[index ?? -1];
    const part = document.bufferViews?.[accessor?.bufferView ?? -1];
    if (!accessor || !part || accessor.sparse !== undefined || document.buffers?.[part.buffer]?.uri !== undefined) {
      throw new Error("The meshes of this file are packed in a way that is not drawn here.");
    }
    const at = binary + (part.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    return { at, count: accessor.count, stride: part.byteStride, type: accessor.componentType };
  };
  const add = (mesh: number, matrix: Matrix4) => {
    for (const { attributes, indices, mode = TRIANGLES } of document.meshes?.[mesh]?.primitives ?? []) {
      if (mode !== TRIANGLES) continue;
      const { at, count, stride = 12 } = place(attributes.POSITION);
      const first = positions.length / 3;
      const point = new Vector3();
      for (let v = 0; v < count; v += 1) {
        const coordinate = (axis: number) => view.getFloat32(at + stride * v + 4 * axis, true);
        point.set(coordinate(0), coordinate(1), coordinate(2)).applyMatrix4(matrix);
        positions.push(point.x, point.y, point.z);
      }
      if (indices === undefined) for (let v = 0; v < count; v += 1) faces.push(first + v);
      else {
        const corners = place(indices);
        const [bytes, get] = INDEX[corners.type] ?? [4, "getUint32"];
        for (let k = 0; k < corners.count; k += 1) faces.push(first + view[get](corners.at + bytes * k, true));
      }
    }
  };
  const visit = (index: number, above: Matrix4, depth: number) => {
    const node = document.nodes?.[index];
    if (!node || depth > DEEPEST) return;
    const own = node.matrix
      ? new Matrix4().fromArray(node.matrix)
      : new Matrix4().compose(
          new Vector3(...(node.translation ?? [0, 0, 0])),
          new Quaternion(...(node.rotation ?? [0, 0, 0, 1])),
          new Vector3(...(node.scale ?? [1, 1, 1])),
        );
    const matrix = above.clone().multiply(own);
    if (node.mesh !== undefined) add(node.mesh, matrix);
    for (const child of node.children ?? []) visit(child, matrix, depth + 1);
  };
  const roots = document.scenes?.[document.scene ?? 0]?.nodes;
  if (roots) for (const root of roots) visit(root, new Matrix4(), 0);
  else document.meshes?.forEach((_, mesh) => add(mesh, new Matrix4()));
  return { positions: Float32Array.from(positions), faces: Uint32Array.from(faces) };
}
