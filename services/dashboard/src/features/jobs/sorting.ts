import { type Asset, JOB_STATES, type Job } from "@/api/types";
import { jobName } from "./naming";

export type Column = "name" | "state" | "took" | "created";

export interface Order {
  by: Column;
  descending: boolean;
}

/** Put jobs in an order of their own; null leaves them as the server lists them, the newest first. */
export function sorted(
  jobs: readonly Job[],
  order: Order | null,
  assets: ReadonlyMap<string, Asset>,
  now: number,
): Job[] {
  if (!order) return [...jobs];
  const keyed = jobs.map((job) => ({ job, key: key(job, order.by, assets, now) }));
  const sign = order.descending ? -1 : 1;
  // Ids begin with the time: the jobs of a batch are made at once, and have an order all the same.
  const sort = (one: (typeof keyed)[number], other: (typeof keyed)[number]) =>
    compare(one.key, other.key) || (one.job.id < other.job.id ? -1 : 1);
  return keyed.sort((one, other) => sign * sort(one, other)).map(({ job }) => job);
}

function key(job: Job, by: Column, assets: ReadonlyMap<string, Asset>, now: number): string | number {
  if (by === "name") return jobName(job, assets);
  if (by === "state") return JOB_STATES.indexOf(job.state);
  if (by === "created") return Date.parse(job.created_at);
  return job.started_at ? (job.finished_at ? Date.parse(job.finished_at) : now) - Date.parse(job.started_at) : -1;
}

function compare(one: string | number, other: string | number): number {
  if (typeof one === "number" && typeof other === "number") return one - other;
  return String(one).localeCompare(String(other), undefined, { numeric: true, sensitivity: "base" });
}
