import type { BufferGeometry } from "three";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { readSurface, type SurfaceMesh } from "@/viewers/surface/readSurface";
import { readScene } from "./scene";

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
      return (content) => meshOf([new STLLoader().parse(content)]);
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

function readObj(content: ArrayBuffer): SurfaceMesh {
  const parts: BufferGeometry[] = [];
  new OBJLoader().parse(new TextDecoder().decode(content)).traverse((part) => {
    if ("isMesh" in part && "geometry" in part) parts.push(part.geometry as BufferGeometry);
  });
  return meshOf(parts);
}

function meshOf(parts: readonly BufferGeometry[]): SurfaceMesh {
  const arrays = parts.map((part) => part.getAttribute("position").array);
  const positions = new Float32Array(arrays.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const array of arrays) {
    positions.set(array, at);
    at += array.length;
  }
  for (const part of parts) part.dispose();
  // These loaders give each face corners of its own.
  return { positions, faces: Uint32Array.from({ length: positions.length / 3 }, (_, index) => index) };
}

/** Object File Format as text (Geomview): counts, vertices, and polygons, which become fans of triangles. */
function readOff(content: ArrayBuffer): SurfaceMesh {
  const text = new TextDecoder().decode(content).replace(/#.*/g, "");
  const [, dimensions = ""] = /^\s*((?:ST|C|N|4|n)*)OFF\b/.exec(text) ?? [];
  const lines = text
    .replace(/^\s*\w*OFF\b/, "")
    .split("\n")
    .map((line) => line.trim())
    .filter((line) => line !== "")
    .map((line) => line.split(/\s+/).map(Number));
  const [vertices = 0, polygons = 0] = lines[0] ?? [];
  if (dimensions.includes("4") || dimensions.includes("n") || lines.length < 1 + vertices + polygons) {
    throw new Error("This OFF file cannot be drawn here.");
  }
  const positions = new Float32Array(lines.slice(1, 1 + vertices).flatMap((line) => line.slice(0, 3)));
  const faces: number[] = [];
  for (const [count = 0, ...corners] of lines.slice(1 + vertices, 1 + vertices + polygons)) {
    for (let k = 2; k < count; k += 1) faces.push(corners[0] ?? 0, corners[k - 1] ?? 0, corners[k] ?? 0);
  }
  return { positions, faces: Uint32Array.from(faces) };
}
