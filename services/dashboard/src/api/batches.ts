import { queryOptions, useMutation, useQueryClient } from "@tanstack/react-query";
import { api, body } from "./client";
import { keys } from "./queries";
import type { Batch, BatchCreate } from "./types";

export const batchKeys = {
  lists: ["batches", "list"] as const,
  list: (cursor: string | undefined) => ["batches", "list", cursor ?? ""] as const,
  one: (id: string) => ["batches", "one", id] as const,
};

export const batchesQuery = (cursor?: string) =>
  queryOptions({
    queryKey: batchKeys.list(cursor),
    queryFn: ({ signal }) =>
      body(api.GET("/v1/batches", { params: { query: { limit: 25, ...(cursor ? { cursor } : {}) } }, signal })),
  });

export const batchQuery = (id: string) =>
  queryOptions({
    queryKey: batchKeys.one(id),
    queryFn: ({ signal }) => body(api.GET("/v1/batches/{batch_id}", { params: { path: { batch_id: id } }, signal })),
  });

export function useCreateBatch() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: ({ request, idempotencyKey }: { request: BatchCreate; idempotencyKey: string }) =>
      body(
        api.POST("/v1/batches", { body: request, params: { header: { "Idempotency-Key": idempotencyKey } } }),
      ) as Promise<Batch>,
    onSuccess: (batch) => {
      client.setQueryData(batchKeys.one(batch.id), batch);
      void client.invalidateQueries({ queryKey: batchKeys.lists });
      void client.invalidateQueries({ queryKey: keys.jobLists });
    },
  });
}

/** Cancel what has not ended of a batch, or run again what failed. */
export function useBatchAction(id: string) {
  const client = useQueryClient();
  return useMutation({
    mutationFn: (action: "cancel" | "retry") => {
      const params = { path: { batch_id: id } };
      return action === "cancel"
        ? body(api.POST("/v1/batches/{batch_id}/cancel", { params }))
        : body(api.POST("/v1/batches/{batch_id}/retry", { params }));
    },
    onSettled: () => {
      void client.invalidateQueries({ queryKey: ["batches"] });
      void client.invalidateQueries({ queryKey: keys.jobLists });
    },
  });
}
