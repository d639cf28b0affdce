import type { components, operations } from "./schema";

type Schemas = components["schemas"];

export type Asset = Schemas["AssetView"];
export type AssetKind = Schemas["AssetKind"];
export type Job = Schemas["JobView"];
export type JobState = Schemas["JobState"];
export type JobEvent = Schemas["JobEvent"];
export type JobCreate = Schemas["JobCreate"];
export type Artifact = Schemas["ArtifactView"];
export type JobKind = Schemas["JobKindView"];
export type Batch = Schemas["BatchView"];
export type BatchCreate = Schemas["BatchCreate"];
export type BatchItem = Schemas["BatchItem"];
export type Shape = Schemas["ShapeView"];
export type ShapeDetail = Schemas["ShapeDetail"];
export type ShapeUpdate = Schemas["ShapeUpdate"];
export type Collection = Schemas["CollectionView"];
export type LabelCount = Schemas["LabelCount"];
export type SearchRequest = Schemas["SearchRequest"];
export type SearchAnswer = Schemas["SearchAnswer"];
export type SearchHit = Schemas["SearchHit"];
export type Key = Schemas["KeyView"];
export type Scope = Schemas["Scope"];
export type Readiness = Schemas["ReadyView"];
export type Usage = Schemas["UsageView"];
export type ServerInfo = Schemas["ServerInfo"];

export type JobOrder = NonNullable<NonNullable<operations["listJobs"]["parameters"]["query"]>["order"]>;
export type ShapeOrder = NonNullable<NonNullable<operations["listShapes"]["parameters"]["query"]>["order"]>;

export const JOB_STATES = [
  "queued",
  "running",
  "cancelling",
  "succeeded",
  "failed",
  "crashed",
  "cancelled",
] as const satisfies readonly JobState[];

/** States that nothing but a retry by the user leads out of. */
export function isTerminal(state: JobState): boolean {
  return state === "succeeded" || state === "failed" || state === "crashed" || state === "cancelled";
}

export function canCancel(state: JobState): boolean {
  return state === "queued" || state === "running";
}

export function canRetry(state: JobState): boolean {
  return state === "failed" || state === "crashed" || state === "cancelled";
}
