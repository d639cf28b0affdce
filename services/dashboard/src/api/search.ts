import { queryOptions } from "@tanstack/react-query";
import { api, body } from "./client";
import type { Job, SearchAnswer, SearchRequest } from "./types";

/** What is looked for: like a stored shape or an uploaded mesh, or like some parts of it. */
export interface Search {
  shape?: string | undefined;
  asset?: string | undefined;
  /** Parts of the query's finest level; without, all of it. */
  parts?: readonly number[] | undefined;
  mode?: "global" | "partial" | undefined;
  collection?: string | undefined;
  labels?: Readonly<Record<string, string>> | undefined;
  rerank?: boolean | undefined;
}

/** An answer, or the job that makes one. */
export type Found = { answer: SearchAnswer } | { job: Job };

const [WAIT, LIMIT] = [15, 40];

export function requestOf({ shape, asset, parts, mode, collection, labels, rerank }: Search): SearchRequest {
  return {
    ...(shape ? { shape_id: shape } : { asset_id: asset ?? null }),
    ...(parts?.length ? { parts: [...parts] } : {}),
    mode: parts?.length ? "partial" : (mode ?? "global"),
    ...(collection ? { collection } : {}),
    labels: { ...labels },
    limit: LIMIT,
    rerank: rerank ?? false,
  };
}

/**
 * Search; `round` counts how often one wanted it anew. What takes a job (a mesh has to be analysed first) is done once
 * for each round: who reloads the page or passes its address on sees the same answer.
 */
export const searchQuery = (search: Search, round: number) => {
  const request = requestOf(search);
  return queryOptions({
    queryKey: ["search", request, round],
    queryFn: async ({ signal }): Promise<Found> => {
      const header = search.asset ? { "Idempotency-Key": `search ${digest(JSON.stringify(request))} ${round}` } : {};
      const params = { query: { wait: search.asset ? 1 : WAIT }, header };
      return told(await body(api.POST("/v1/search", { body: request, params, signal })));
    },
    staleTime: Number.POSITIVE_INFINITY,
    refetchOnWindowFocus: false,
    retry: false,
  });
};

/** What a search's job has found so far. */
export const searchJobQuery = (jobId: string) =>
  queryOptions({
    queryKey: ["search", "job", jobId],
    queryFn: async ({ signal }): Promise<Found> =>
      told(await body(api.GET("/v1/search/{job_id}", { params: { path: { job_id: jobId } }, signal }))),
    retry: false,
  });

function told(found: SearchAnswer | Job): Found {
  return "hits" in found ? { answer: found } : { job: found };
}

/** 64 bits that tell one text from another (FNV-1a); `crypto.subtle` is there over HTTPS only. */
function digest(text: string): string {
  let hash = 0xcbf29ce484222325n;
  for (const byte of new TextEncoder().encode(text)) {
    hash = BigInt.asUintN(64, (hash ^ BigInt(byte)) * 0x100000001b3n);
  }
  return hash.toString(16);
}
