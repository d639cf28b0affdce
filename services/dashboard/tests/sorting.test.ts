import { expect, it } from "vitest";
import type { Job } from "@/api/types";
import { sorted } from "@/features/jobs/sorting";

const job = (id: string, state: Job["state"], started: number | null, finished: number | null) =>
  ({
    id,
    state,
    inputs: {},
    created_at: "2026-01-01T00:00:00Z",
    started_at: started === null ? null : new Date(started).toISOString(),
    finished_at: finished === null ? null : new Date(finished).toISOString(),
  }) as unknown as Job;
const JOBS = [
  job("00000010", "failed", 0, 9_000),
  job("00000009", "queued", null, null),
  job("00000002", "running", 0, null),
  job("00000001", "failed", 0, 3_000),
];
const ids = (by: "name" | "state" | "took" | "created", descending: boolean) =>
  sorted(JOBS, { by, descending }, new Map(), 5_000).map(({ id }) => Number(id));

it("sorts jobs by their columns, those that are alike by their ids", () => {
  expect(ids("took", false)).toEqual([9, 1, 2, 10]); // what has not begun, and what still runs, among them
  expect(ids("took", true)).toEqual([10, 2, 1, 9]);
  expect(ids("state", false)).toEqual([9, 2, 1, 10]);
  expect(ids("name", false)).toEqual([1, 2, 9, 10]);
  expect(ids("created", false)).toEqual([1, 2, 9, 10]);
  expect(sorted(JOBS, null, new Map(), 0)).toEqual(JOBS);
});
