import { apiFetch } from "@/api/client";
import type { SurfaceMesh } from "./surface/readSurface";

/** Fetch one of our meshes: a PLY, or the one mesh of a `mesh.glb`. */
export async function readMeshAt(url: string): Promise<SurfaceMesh> {
  const content = await (await apiFetch(url)).arrayBuffer();
  if (url.endsWith(".glb")) return (await import("./shape/glb")).readGlb(content);
  return (await import("./surface/readSurface")).readSurface(content);
}
