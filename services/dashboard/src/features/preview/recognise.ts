import type { Asset } from "@/api/types";
import { isMeshName, readArchive } from "./archive";

/** What a file seems to be, before the server has looked at it. */
export type Seems = Pick<Asset, "kind" | "format">;

const MESHES = /\.(obj|ply|stl|off|glb)$/i;

/** Tell from its first bytes, and where those say little from its name, how a file can be drawn; null for the unknown. */
export async function recognise(file: Blob, name: string): Promise<Seems | null> {
  const packed = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  const gzipped = packed[0] === 0x1f && packed[1] === 0x8b;
  const bytes = gzipped ? await unpacked(file, 352) : new Uint8Array(await file.slice(0, 352).arrayBuffer());
  const head = new TextDecoder("latin1").decode(bytes);
  if (head.slice(344, 346) === "n+" || head.slice(344, 346) === "ni") return { kind: "volume", format: "nifti1" };
  if (gzipped) return null;
  if (head.startsWith("NRRD")) return { kind: "volume", format: "nrrd" };
  if (/^\s*(ObjectType|NDims|Comment)\s*=/.test(head)) return { kind: "volume", format: "metaimage" };
  if (head.slice(128, 132) === "DICM") return { kind: "volume", format: "dicom" };
  if (head.startsWith("PK")) return inArchive(file);
  if (head.startsWith("ply")) return { kind: "mesh", format: "ply" };
  if (head.startsWith("glTF")) return { kind: "mesh", format: "glb" };
  if (/^(ST|C|N)*OFF\b/.test(head)) return { kind: "mesh", format: "off" };
  if (/\.smc$/i.test(name)) return { kind: "motion", format: "smc" };
  const [ending] = MESHES.exec(name) ?? [];
  return ending ? { kind: "mesh", format: ending.slice(1).toLowerCase() } : null;
}

async function inArchive(file: Blob): Promise<Seems | null> {
  const entries = await readArchive(file);
  if (entries.some(({ name }) => name === "vertices.npy")) return { kind: "sequence", format: "npz" };
  if (entries.some(({ name, size }) => size > 0 && isMeshName(name))) return { kind: "sequence", format: "mesh-zip" };
  for (const entry of entries.slice(0, 16)) {
    const magic = new Uint8Array(await entry.read(132)).subarray(128);
    if (new TextDecoder("latin1").decode(magic) === "DICM") return { kind: "volume", format: "dicom-zip" };
  }
  return null;
}

/** The first bytes of what is gzipped. */
async function unpacked(file: Blob, most: number): Promise<Uint8Array> {
  const reader = file.slice(0, 65_536).stream().pipeThrough(new DecompressionStream("gzip")).getReader();
  const { value = new Uint8Array() } = await reader.read();
  void reader.cancel();
  return value.subarray(0, most);
}
