import { inflate, readNifti } from "@/format/nifti";
import { type Overlap, overlap } from "./overlap";

export type CompareAnswer = { overlap: Overlap } | { problem: string };

self.onmessage = async ({ data }: MessageEvent<{ ours: ArrayBuffer; theirs: ArrayBuffer }>) => {
  let answer: CompareAnswer;
  try {
    answer = { overlap: overlap(readNifti(await inflate(data.ours)), readNifti(await inflate(data.theirs))) };
  } catch (error) {
    answer = { problem: error instanceof Error ? error.message : String(error) };
  }
  self.postMessage(answer);
};
