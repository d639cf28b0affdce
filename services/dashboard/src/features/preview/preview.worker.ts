import type { Seems } from "./recognise";
import { recognise } from "./recognise";
import { meshPicture, type Picture, sliceOf } from "./picture";
import { reasonOf } from "./reason";

/** A picture of a file, or, of a volume, the same as a file that the viewers read. */
export type Ask = { draw: Blob; name: string; size: number } | { convert: Blob; format: string };
export type Told = { picture: Picture | null; seems: Seems | null } | { volume: Blob } | { problem: string };

/** Larger files are not read whole for a small picture. */
const MOST = 512 << 20;
/** Of a volume, so many are enough for a small picture. */
const VOXELS = 2 ** 21;

self.onmessage = ({ data }: MessageEvent<Ask>) => {
  const work = "draw" in data ? draw(data.draw, data.name, data.size) : convert(data.convert, data.format);
  void work.catch((error: unknown): Told => ({ problem: reasonOf(error) })).then((told) => self.postMessage(told));
};

async function draw(file: Blob, name: string, size: number): Promise<Told> {
  const seems = file.size <= MOST ? await recognise(file, name) : null;
  if (!seems) return { picture: null, seems };
  return { picture: await pictureOf(file, seems, size), seems };
}

/** Readers are fetched when a file needs them. */
async function pictureOf(file: Blob, { kind, format }: Seems, size: number): Promise<Picture | null> {
  if (kind === "volume") {
    const { asNifti, readCoarse } = await import("./volume");
    return sliceOf(await readCoarse(await asNifti(file, format), VOXELS), size);
  }
  if (kind === "mesh") return meshPicture((await import("./mesh")).readMesh(await file.arrayBuffer(), format), size);
  if (kind === "sequence") {
    const { faces, positions } = await (await import("./sequence")).openSequence(file);
    return meshPicture({ faces, positions: await positions(0) }, size);
  }
  const { Motion } = await import("@/features/motion/smc/motion");
  const motion = new Motion(new Uint8Array(await file.arrayBuffer()));
  const positions = new Float32Array(motion.frame(0, new Float64Array(3 * motion.header.vertices)));
  return meshPicture({ positions, faces: motion.faces }, size);
}

async function convert(file: Blob, format: string): Promise<Told> {
  return { volume: await (await import("./volume")).asNifti(file, format) };
}
