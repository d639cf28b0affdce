import type { Batch, JobState } from "@/api/types";
import { workName } from "@/features/jobs/naming";
import { moment } from "@/format/format";

/** "Segmentation, 25 Nov 2026, 20:14": batches have no name of their own. */
export function batchName({ kind, created_at }: Pick<Batch, "kind" | "created_at">): string {
  return `${workName(kind)}, ${moment(created_at)}`;
}

export function count({ counts }: Pick<Batch, "counts">, ...states: JobState[]): number {
  return states.reduce((sum, state) => sum + (counts[state] ?? 0), 0);
}

/** Jobs that a retry of the batch runs again. */
export function troubled(batch: Pick<Batch, "counts">): number {
  return count(batch, "failed", "crashed");
}

/** Jobs that have ended, however. */
export function ended(batch: Pick<Batch, "counts">): number {
  return count(batch, "succeeded", "failed", "crashed", "cancelled");
}

/** How a batch stands, in a few words: "7 of 12 done, 2 failed". */
export function standing(batch: Pick<Batch, "counts" | "total">): string {
  const parts = [`${ended(batch)} of ${batch.total} done`];
  const bad = troubled(batch);
  const cancelled = count(batch, "cancelled");
  const running = count(batch, "running", "cancelling");
  if (bad > 0) parts.push(`${bad} failed`);
  if (cancelled > 0) parts.push(`${cancelled} cancelled`);
  if (running > 0) parts.push(`${running} running`);
  return parts.join(", ");
}
