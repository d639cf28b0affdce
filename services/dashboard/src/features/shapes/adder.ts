import { api, body } from "@/api/client";
import { takeUp, uploads } from "@/features/uploads/uploads";
import { Adding } from "./adding";
import { additionKeep } from "./additionKeep";

/** The additions of this page. */
export const adding = new Adding({
  uploads,
  asset: (id) => body(api.GET("/v1/assets/{asset_id}", { params: { path: { asset_id: id } } })),
  createBatch: (request, key) =>
    body(api.POST("/v1/batches", { body: request, params: { header: { "Idempotency-Key": key } } })),
  batchLimit: async () => (await body(api.GET("/v1/info"))).max_batch_items,
  keep: additionKeep,
  exclusively: takeUp,
  now: Date.now,
});

void uploads.restored.then(() => adding.restore());
