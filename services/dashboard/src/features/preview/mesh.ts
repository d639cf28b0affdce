import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { readSurface, type SurfaceMesh } from "@/viewers/surface/readSurface";
import { readScene } from "./scene";
import { readObj, readOff } from "./textMesh";

/** Read a mesh; `format` is what it was found to be, or a name that ends so. Throws a sentence. */
export function readMesh(content: ArrayBuffer, format: string): SurfaceMesh {
  const mesh = reader(format.toLowerCase().split(".").at(-1) ?? "")(content);
  if (mesh.positions.length === 0) throw new Error("The file holds no vertices.");
  return mesh;
}

function reader(format: string): (content: ArrayBuffer) => SurfaceMesh {
  switch (format) {
    case "ply":
      return readSurface;
    case "stl":
      return readStl;
    case "obj":
      return readObj;
    case "off":
      return readOff;
    case "glb":
      return readScene;
    default:
      throw new Error("Meshes of this format are not drawn here.");
  }
}

/** Read an STL file, of which each face has corners of its own. */
function readStl(content: ArrayBuffer): SurfaceMesh {
  const view = new DataView(content);
  const count = content.byteLength >= 84 ? view.getUint32(80, true) : 0;
  const positions = content.byteLength === 84 + 50 * count ? binaryStl(view, count) : textStl(content);
  return { positions, faces: Uint32Array.from({ length: positions.length / 3 }, (_, index) => index) };
}

/** Of each face a normal, three corners and two bytes of nothing. */
function binaryStl(view: DataView, count: number): Float32Array {
  const positions = new Float32Array(9 * count);
  for (let f = 0, to = 0; f < count; f += 1) {
    for (let at = 84 + 50 * f + 12; to < 9 * (f + 1); at += 4, to += 1) positions[to] = view.getFloat32(at, true);
  }
  return positions;
}

function textStl(content: ArrayBuffer): Float32Array {
  const geometry = new STLLoader().parse(content);
  const positions = new Float32Array(geometry.getAttribute("position").array);
  geometry.dispose();
  return positions;
}
