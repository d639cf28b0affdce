import type { Search } from "@/api/search";
import { readLabels } from "./labels";

/** A search as its address tells it. */
export interface SearchAddress {
  shape?: string | undefined;
  asset?: string | undefined;
  /** Numbers with commas between them. */
  parts?: string | undefined;
  mode?: "partial" | undefined;
  collection?: string | undefined;
  labels?: string[] | undefined;
  rerank?: true | undefined;
  /** How often it was wanted anew. */
  round?: number | undefined;
}

export function writeParts(parts: readonly number[]): string {
  return parts.join(",");
}

export function readParts(text: string | undefined): number[] {
  const numbers = (text ?? "").split(",").filter((part) => /^\d+$/.test(part));
  return [...new Set(numbers.map(Number))].slice(0, 64);
}

export function searchOf({ shape, asset, parts, mode, collection, labels, rerank }: SearchAddress): Search {
  return {
    ...(shape ? { shape } : { asset }),
    parts: readParts(parts),
    mode,
    collection,
    labels: readLabels(labels ?? []),
    rerank,
  };
}

/** What an address holds of a search; what makes no sense is undefined, so that it does not pass as it stands there. */
export function readAddress(given: Record<string, unknown>): SearchAddress {
  const text = (value: unknown) => (typeof value === "string" || typeof value === "number" ? String(value) : undefined);
  const [shape, asset, parts, collection] = [given.shape, given.asset, given.parts, given.collection].map(text);
  const labels = [given.labels].flat().filter((label) => typeof label === "string");
  return {
    shape: shape || undefined,
    asset: shape ? undefined : asset || undefined,
    parts: writeParts(readParts(parts)) || undefined,
    mode: given.mode === "partial" ? "partial" : undefined,
    collection: collection || undefined,
    labels: labels.length > 0 ? labels : undefined,
    rerank: given.rerank === true || undefined,
    round: typeof given.round === "number" && given.round > 0 ? given.round : undefined,
  };
}
