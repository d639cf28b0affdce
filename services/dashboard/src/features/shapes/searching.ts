import type { Search } from "@/api/search";
import { readLabels } from "./labels";

/** A search as its address tells it. */
export interface SearchAddress {
  shape?: string;
  asset?: string;
  /** Numbers with commas between them. */
  parts?: string;
  mode?: "partial";
  collection?: string;
  labels?: string[];
  rerank?: true;
  /** How often it was wanted anew. */
  round?: number;
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

/** What an address holds of a search; everything else is left out. */
export function readAddress(given: Record<string, unknown>): SearchAddress {
  const text = (value: unknown) => (typeof value === "string" || typeof value === "number" ? String(value) : undefined);
  const [shape, asset, parts, collection] = [given.shape, given.asset, given.parts, given.collection].map(text);
  const labels = Array.isArray(given.labels) ? given.labels.filter((label) => typeof label === "string") : [];
  return {
    ...(shape ? { shape } : asset ? { asset } : {}),
    ...(parts && readParts(parts).length > 0 ? { parts: writeParts(readParts(parts)) } : {}),
    ...(given.mode === "partial" ? { mode: "partial" } : {}),
    ...(collection ? { collection } : {}),
    ...(labels.length > 0 ? { labels } : {}),
    ...(given.rerank === true ? { rerank: true } : {}),
    ...(typeof given.round === "number" && given.round > 0 ? { round: given.round } : {}),
  };
}
