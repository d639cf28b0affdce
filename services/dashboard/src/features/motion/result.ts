import type { components } from "@/api/schema";

export type MotionResult = components["schemas"]["MotionEncodeResult"];

/** Whether a job's result has the form of a compressed motion's. */
export function isMotionResult(result: unknown): result is MotionResult {
  return typeof result === "object" && result !== null && "file" in result && "motion_bits_per_vertex_frame" in result;
}
