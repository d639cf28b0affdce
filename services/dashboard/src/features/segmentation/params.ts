import type { components } from "@/api/schema";

export type SegmentationParams = components["schemas"]["SegmentationParams"];
export type SegmentationResult = components["schemas"]["SegmentationResult"];
export type SegmentedObject = components["schemas"]["SegmentedObject"];

/** Read seed points as people write them: three numbers each (RAS mm), one point to a line or separated by semicolons. */
export function parseSeeds(text: string): {
  seeds: [number, number, number][];
  problem: string | null;
} {
  const seeds: [number, number, number][] = [];
  for (const line of text.split(/[\n;]/)) {
    if (!line.trim()) continue;
    const numbers = line
      .trim()
      .split(/[\s,]+/)
      .map(Number);
    const [x, y, z, ...rest] = numbers;
    if (x === undefined || y === undefined || z === undefined || rest.length > 0 || !numbers.every(Number.isFinite)) {
      return {
        seeds: [],
        problem: `“${line.trim()}” is not a point: give three numbers, like 12.5, -30, 41.`,
      };
    }
    seeds.push([x, y, z]);
  }
  if (seeds.length > 64)
    return {
      seeds: [],
      problem: `Up to 64 seeds are taken; these are ${seeds.length}.`,
    };
  return { seeds, problem: null };
}

/** Whether a job's result has the form of a segmentation's. */
export function isSegmentationResult(result: unknown): result is SegmentationResult {
  return typeof result === "object" && result !== null && "objects" in result && Array.isArray(result.objects);
}
