import type { Job } from "@/api/types";
import { isSegmentationResult } from "@/features/segmentation/params";
import { isMotionResult } from "@/features/motion/result";
import { isIndexResult, isSearchResult } from "@/features/shapes/result";
import { bytes, capital, integer, significant, volume } from "@/format/format";

const WORK: Record<string, string> = {
  segmentation: "Segmentation",
  "motion-encode": "Compression",
  "motion-decode": "Decompression",
  "shape-index": "Indexing",
  "shape-search": "Shape search",
};

/** What a kind of jobs does. */
export function workName(kind: string): string {
  return WORK[kind] ?? capital(kind);
}

/** The input that a job is known by: the first file of its main input. */
export function mainInput(job: Pick<Job, "inputs">): string | null {
  return (job.inputs.post ?? Object.values(job.inputs)[0])?.[0] ?? null;
}

export function jobName({ id, name }: Pick<Job, "id" | "name">): string {
  return name || `Job ${id.slice(-8)}`;
}

/** Seconds that a job has been worked on; null where nobody has begun, or where it waits to be tried again. */
export function secondsSpent({ state, started_at: began, finished_at: ended }: Job, now: number): number | null {
  if (!began || state === "queued") return null;
  return ((ended ? Date.parse(ended) : now) - Date.parse(began)) / 1000;
}

/** What came out of a job, in a few words. */
export function outcome(job: Job): string {
  if (job.expired) return "The results have expired";
  if (job.state === "cancelled") return "Called off";
  if (isSegmentationResult(job.result)) {
    const { objects } = job.result;
    if (objects.length === 0) return "Nothing found";
    const core = objects.reduce((sum, object) => sum + object.core_volume_mm3, 0);
    return `${objects.length === 1 ? "1 object" : `${objects.length} objects`}, ${volume(core)}`;
  }
  if (isMotionResult(job.result)) {
    const { bytes: size, frames, errors } = job.result;
    return `${bytes(size)} for ${integer(frames)} frames, KG error ${significant(errors.kg_percent, 2)}\u00a0%`;
  }
  if (isIndexResult(job.result)) return `In the bank, ${job.result.levels.at(-1)?.parts ?? 0} parts`;
  if (isSearchResult(job.result)) return `${integer(job.result.hits.length)} found`;
  return "";
}
