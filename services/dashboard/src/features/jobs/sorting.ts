import type { JobOrder } from "@/api/types";

export type Column = "name" | "state" | "took" | "created";

export const NEWEST_FIRST: JobOrder = "-created";

/** What one wants to see first where a column is sorted by: the newest and the longest, "a" before "b". */
const FIRST: Readonly<Record<Column, JobOrder>> = {
  name: "name",
  state: "state",
  took: "-took",
  created: NEWEST_FIRST,
};

/** How a column is sorted, in the words of `aria-sort`. */
export function sortOf(order: JobOrder, by: Column): "ascending" | "descending" | "none" {
  return order === by ? "ascending" : order === `-${by}` ? "descending" : "none";
}

/** The order that a click on the head of a column leads to: its own, and the other way around. */
export function reordered(order: JobOrder, by: Column): JobOrder {
  const sorted = sortOf(order, by);
  return sorted === "none" ? FIRST[by] : sorted === "ascending" ? `-${by}` : by;
}

/** What the pages before and after one are called. */
export function pageNames(order: JobOrder): { before: string; after: string } {
  return order === NEWEST_FIRST ? { before: "Newer", after: "Older" } : { before: "Previous", after: "Next" };
}
