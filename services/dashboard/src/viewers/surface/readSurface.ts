import { PLYLoader } from "three/examples/jsm/loaders/PLYLoader.js";

/** A triangle mesh: x, y, z of each vertex in RAS mm, and three vertices for each face. */
export interface SurfaceMesh {
  positions: Float32Array;
  faces: Uint32Array;
}

/** Read a PLY file. Ours are written in double precision, which graphics cards don't take. */
export function readSurface(content: ArrayBuffer): SurfaceMesh {
  const geometry = new PLYLoader().parse(content);
  const positions = new Float32Array(geometry.getAttribute("position").array);
  const faces = new Uint32Array(geometry.getIndex()?.array ?? []);
  geometry.dispose();
  return { positions, faces };
}
