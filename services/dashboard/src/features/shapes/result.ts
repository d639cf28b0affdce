import type { components } from "@/api/schema";
import type { Job } from "@/api/types";
import type { SearchAddress } from "./searching";
import { writeLabels } from "./labels";
import { writeParts } from "./searching";

type IndexResult = components["schemas"]["ShapeIndexResult"];
type SearchResult = components["schemas"]["ShapeSearchResult"];

export function isIndexResult(result: unknown): result is IndexResult {
  return typeof result === "object" && result !== null && "levels" in result && "arg" in result;
}

export function isSearchResult(result: unknown): result is SearchResult {
  return typeof result === "object" && result !== null && "hits" in result && Array.isArray(result.hits);
}

/** Where the search that a job has made can be seen. */
export function addressOf(job: Pick<Job, "inputs" | "params">): SearchAddress {
  const params = job.params as Partial<components["schemas"]["ShapeSearchParams"]>;
  const asset = job.inputs.mesh?.[0];
  const labels = writeLabels(params.filter?.labels ?? {});
  return {
    ...(params.shape_id ? { shape: params.shape_id } : asset ? { asset } : {}),
    ...(params.parts?.length ? { parts: writeParts(params.parts) } : {}),
    ...(params.mode === "partial" && !params.parts?.length ? { mode: "partial" as const } : {}),
    ...(params.filter?.collection ? { collection: params.filter.collection } : {}),
    ...(labels.length > 0 ? { labels } : {}),
    ...(params.rerank ? { rerank: true as const } : {}),
  };
}
