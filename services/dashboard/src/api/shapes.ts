import {
  infiniteQueryOptions,
  type InfiniteData,
  type QueryClient,
  queryOptions,
  useMutation,
  useQueryClient,
} from "@tanstack/react-query";
import { api, body } from "./client";
import { ApiError } from "./problem";
import type { Batch, Collection, Shape, ShapeDetail, ShapeOrder, ShapeUpdate } from "./types";

/** Which shapes of the bank are shown. */
export interface ShapeFilter {
  collection?: string | undefined;
  /** As `name:value`; all of them. */
  labels?: readonly string[] | undefined;
  /** A text in the name. */
  name?: string | undefined;
  outdated?: boolean | undefined;
  order?: ShapeOrder | undefined;
}

export const shapeKeys = {
  all: ["shapes"] as const,
  lists: ["shapes", "list"] as const,
  list: (filter: ShapeFilter) => ["shapes", "list", filter] as const,
  one: (id: string) => ["shapes", "one", id] as const,
  labels: (collection: string | undefined) => ["shapes", "labels", collection ?? ""] as const,
  collections: ["collections"] as const,
};

const PAGE = 200;

export interface ShapePage {
  items: Shape[];
  next_cursor?: string | null;
}

/** Shapes in an order, a page after another. */
export const shapesQuery = (filter: ShapeFilter) =>
  infiniteQueryOptions({
    queryKey: shapeKeys.list(filter),
    queryFn: ({ pageParam, signal }): Promise<ShapePage> =>
      body(
        api.GET("/v1/shapes", {
          params: {
            query: {
              limit: PAGE,
              ...(pageParam ? { cursor: pageParam } : {}),
              ...(filter.collection ? { collection: filter.collection } : {}),
              ...(filter.labels?.length ? { label: [...filter.labels] } : {}),
              ...(filter.name ? { name: filter.name } : {}),
              ...(filter.outdated ? { outdated: true } : {}),
              ...(filter.order ? { order: filter.order } : {}),
            },
          },
          signal,
        }),
      ),
    initialPageParam: "",
    getNextPageParam: ({ next_cursor }) => next_cursor ?? undefined,
    staleTime: 60_000,
    // Thousands are not asked for anew because somebody came back to the window.
    refetchOnWindowFocus: (query) => ((query.state.data as InfiniteData<ShapePage> | undefined)?.pages.length ?? 0) < 3,
  });

export const shapeQuery = (id: string) =>
  queryOptions({
    queryKey: shapeKeys.one(id),
    queryFn: ({ signal }) =>
      body(api.GET("/v1/shapes/{shape_id}", { params: { path: { shape_id: id } }, signal })) as Promise<ShapeDetail>,
  });

/** The shape that a job has indexed; null where it is deleted, or was indexed again. */
export const shapeOfJobQuery = (jobId: string) =>
  queryOptions({
    queryKey: ["shapes", "of job", jobId] as const,
    queryFn: async ({ signal }) => {
      const page = await body(api.GET("/v1/shapes", { params: { query: { job_id: jobId, limit: 1 } }, signal }));
      return page.items[0] ?? null;
    },
  });

export const labelsQuery = (collection: string | undefined) =>
  queryOptions({
    queryKey: shapeKeys.labels(collection),
    queryFn: ({ signal }) =>
      body(api.GET("/v1/labels", { params: { query: collection ? { collection } : {} }, signal })),
    staleTime: 20_000,
  });

/** All collections by name. */
export const collectionsQuery = queryOptions({
  queryKey: shapeKeys.collections,
  queryFn: async ({ signal }) => {
    const all: Collection[] = [];
    for (let cursor: string | null | undefined = ""; cursor !== null && cursor !== undefined;) {
      const query: { limit: number; cursor?: string } = { limit: PAGE, ...(cursor ? { cursor } : {}) };
      const page: { items: Collection[]; next_cursor?: string | null } = await body(
        api.GET("/v1/collections", { params: { query }, signal }),
      );
      all.push(...page.items);
      cursor = page.next_cursor;
    }
    return all.sort((one, other) => one.name.localeCompare(other.name));
  },
  staleTime: 10_000,
});

/** Change every cached copy of a shape; null takes it out. */
function replace(client: QueryClient, id: string, change: (shape: Shape) => Shape | null): void {
  client.setQueriesData<InfiniteData<ShapePage>>({ queryKey: shapeKeys.lists }, (data) => {
    if (!data?.pages.some(({ items }) => items.some((shape) => shape.id === id))) return data;
    return {
      ...data,
      pages: data.pages.map((page) => ({
        ...page,
        items: page.items.flatMap((shape) => (shape.id === id ? (change(shape) ?? []) : [shape])),
      })),
    };
  });
}

/** What a list's filters may now see otherwise: asked for anew when it is shown next. */
function refresh(client: QueryClient): void {
  void client.invalidateQueries({ queryKey: shapeKeys.lists, refetchType: "none" });
  void client.invalidateQueries({ queryKey: ["shapes", "labels"] });
  void client.invalidateQueries({ queryKey: shapeKeys.collections });
}

export function useUpdateShape() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: ({ id, change }: { id: string; change: ShapeUpdate }) =>
      body(
        api.PATCH("/v1/shapes/{shape_id}", { params: { path: { shape_id: id } }, body: change }),
      ) as Promise<ShapeDetail>,
    onSuccess: (shape) => {
      client.setQueryData(shapeKeys.one(shape.id), shape);
      replace(client, shape.id, () => shape);
      refresh(client);
    },
  });
}

export function useDeleteShape() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: (id: string) => body(api.DELETE("/v1/shapes/{shape_id}", { params: { path: { shape_id: id } } })),
    onSuccess: (_nothing, id) => {
      client.removeQueries({ queryKey: shapeKeys.one(id) });
      replace(client, id, () => null);
      refresh(client);
    },
  });
}

/** What shows something else when shapes or collections have changed; meshes and pictures stay. */
const changing = [shapeKeys.lists, ["shapes", "one"], ["shapes", "labels"], shapeKeys.collections] as const;

/** Do something as soon as the server takes it: it lets only so many requests come in a minute. */
async function patiently<T>(work: () => Promise<T>): Promise<T> {
  for (let attempt = 0; ; attempt += 1) {
    try {
      return await work();
    } catch (error) {
      if (!(error instanceof ApiError && error.status === 429) || attempt >= 60) throw error;
      await new Promise((resolve) => setTimeout(resolve, 1_000));
    }
  }
}

/** Move shapes to a collection, or delete them, one after another; shapes that have left their list vanish from it. */
export function useChangeShapes() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: async ({ ids, collection }: { ids: readonly string[]; collection: string | null }) => {
      for (const id of ids) {
        const params = { path: { shape_id: id } };
        await patiently(() =>
          collection === null
            ? body(api.DELETE("/v1/shapes/{shape_id}", { params }))
            : body(api.PATCH("/v1/shapes/{shape_id}", { params, body: { collection } })),
        );
      }
    },
    onSettled: () => {
      for (const queryKey of changing) void client.invalidateQueries({ queryKey });
    },
  });
}

/** Make, rename or delete a collection. */
export function useCollectionAction() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: async (
      action: { make: string } | { rename: string; to: string } | { remove: string; shapes: boolean },
    ) => {
      if ("make" in action) {
        const made = { name: action.make, description: "", metadata: {} };
        await body(api.POST("/v1/collections", { body: made }));
      } else if ("rename" in action) {
        const params = { path: { collection_id: action.rename } };
        await body(api.PATCH("/v1/collections/{collection_id}", { params, body: { name: action.to } }));
      } else {
        const params = { path: { collection_id: action.remove }, query: { shapes: action.shapes } };
        await body(api.DELETE("/v1/collections/{collection_id}", { params }));
      }
    },
    onSettled: () => {
      void client.invalidateQueries({ queryKey: shapeKeys.collections });
      // What is shown may be of a collection that has another name now, or none: whoever shows a list next asks anew.
      for (const queryKey of changing) void client.invalidateQueries({ queryKey, refetchType: "none" });
    },
  });
}

/** Index a collection's outdated shapes again, as a batch. */
export function useReindexCollection() {
  return useMutation({
    mutationFn: (id: string) =>
      body(
        api.POST("/v1/collections/{collection_id}/reindex", { params: { path: { collection_id: id } } }),
      ) as Promise<Batch>,
  });
}
