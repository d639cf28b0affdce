import { signedDistances } from "./distance";
import { inflate, readNifti } from "@/format/nifti";

export interface DistanceQuestion {
  mask: ArrayBuffer;
  /** Values of the mask that count; null: all but 0. */
  values: readonly number[] | null;
  points: Float32Array[];
}

export type DistanceAnswer = { distances: Float32Array[] } | { problem: string };

self.onmessage = async ({ data }: MessageEvent<DistanceQuestion>) => {
  let answer: DistanceAnswer;
  try {
    const mask = readNifti(await inflate(data.mask));
    const counted = new Set(data.values ?? nonzero(mask.values, mask.slope, mask.inter));
    answer = { distances: data.points.map((points) => signedDistances(points, mask, counted)) };
  } catch (error) {
    answer = { problem: error instanceof Error ? error.message : String(error) };
  }
  self.postMessage(answer);
};

function nonzero(values: ArrayLike<number>, slope: number, inter: number): Set<number> {
  const found = new Set<number>();
  for (let index = 0; index < values.length; index += 1) found.add(Math.round((values[index] ?? 0) * slope + inter));
  found.delete(0);
  return found;
}
