import { expect, test } from "vitest";
import type { Job } from "@/api/types";
import { secondsSpent } from "@/features/jobs/naming";

const job = (part: Partial<Job>) => ({ state: "running", started_at: null, finished_at: null, ...part }) as Job;
const began = "2026-11-26T12:00:00Z";
const now = Date.parse("2026-11-26T12:01:30Z");

test("the time that a job takes goes on until it has ended", () => {
  expect(secondsSpent(job({}), now)).toBeNull();
  expect(secondsSpent(job({ started_at: began }), now)).toBe(90);
  expect(secondsSpent(job({ state: "failed", started_at: began, finished_at: "2026-11-26T12:00:07Z" }), now)).toBe(7);
});

test("a job that has crashed and waits to be tried again is not worked on", () => {
  expect(secondsSpent(job({ state: "queued", started_at: began }), now)).toBeNull();
});
