import { expect, it } from "vitest";
import type { JobOrder } from "@/api/types";
import { pageNames, reordered, sortOf } from "@/features/jobs/sorting";

it("turns the order of a column around, and begins another with what one looks for", () => {
  const clicks = ["took", "took", "took", "name", "name", "created", "created"] as const;
  const orders = clicks.reduce<JobOrder[]>((all, by) => [...all, reordered(all.at(-1) ?? "-created", by)], []);
  expect(orders).toEqual(["-took", "took", "-took", "name", "-name", "-created", "created"]);
});

it("tells the order of each column, and what lies before and after a page", () => {
  expect((["created", "took"] as const).map((by) => sortOf("-created", by))).toEqual(["descending", "none"]);
  expect(sortOf("took", "took")).toBe("ascending");
  expect(pageNames("-created").after).toBe("Older");
  expect(pageNames("name").after).toBe("Next");
});
