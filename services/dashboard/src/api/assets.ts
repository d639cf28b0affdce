import { apiFetch } from "./client";
import type { Asset } from "./types";

/** Send something that is here already, and small, in one request; what people bring is uploaded resumably. */
export async function uploadAsset(content: Blob, filename: string): Promise<Asset> {
  const form = new FormData();
  form.append("file", content, filename);
  const response = await apiFetch(`${globalThis.location.origin}/v1/assets`, { method: "POST", body: form });
  return (await response.json()) as Asset;
}
