import { queryOptions, useMutation, useQueryClient } from "@tanstack/react-query";
import { api, body } from "./client";
import type { Scope } from "./types";

const KEY = ["keys"] as const;

export const apiKeysQuery = queryOptions({
  queryKey: KEY,
  queryFn: ({ signal }) => body(api.GET("/v1/keys", { signal })),
});

export function useCreateKey() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: (request: { name: string; scopes: Scope[]; expires_at: string | null }) =>
      body(api.POST("/v1/keys", { body: request })),
    onSuccess: () => client.invalidateQueries({ queryKey: KEY }),
  });
}

export function useRevokeKey() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: (id: string) => body(api.DELETE("/v1/keys/{key_id}", { params: { path: { key_id: id } } })),
    onSettled: () => client.invalidateQueries({ queryKey: KEY }),
  });
}
