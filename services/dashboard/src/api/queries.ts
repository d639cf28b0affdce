import {
  type QueryClient,
  queryOptions,
  replaceEqualDeep,
  useMutation,
  useQuery,
  useQueryClient,
} from "@tanstack/react-query";
import { api, body } from "./client";
import { ApiError } from "./problem";
import type { Asset, Job, JobCreate, JobEvent, JobOrder, JobState, Readiness } from "./types";

export interface JobFilter {
  state?: JobState | undefined;
  kind?: string | undefined;
  /** A text in the name. */
  name?: string | undefined;
  order?: JobOrder | undefined;
  cursor?: string | undefined;
  batch?: string | undefined;
}

export const PAGE_SIZE = 25;

export const keys = {
  info: ["info"] as const,
  kinds: ["kinds"] as const,
  readiness: ["readiness"] as const,
  usage: ["usage"] as const,
  jobLists: ["jobs", "list"] as const,
  jobs: (filter: JobFilter) => ["jobs", "list", filter] as const,
  job: (id: string) => ["jobs", "one", id] as const,
  assetLists: ["assets", "list"] as const,
  assets: (kind: Asset["kind"]) => ["assets", "list", kind] as const,
  asset: (id: string) => ["assets", "one", id] as const,
};

export const infoQuery = queryOptions({
  queryKey: keys.info,
  queryFn: ({ signal }) => body(api.GET("/v1/info", { signal })),
  staleTime: 5 * 60_000,
});

export const kindsQuery = queryOptions({
  queryKey: keys.kinds,
  queryFn: ({ signal }) => body(api.GET("/v1/kinds", { signal })),
  staleTime: 15_000,
});

/** How the parts that the server stands on are; a part that is down makes the answer an error, and is told all the same. */
export const readinessQuery = queryOptions({
  queryKey: keys.readiness,
  queryFn: async ({ signal }): Promise<Readiness> => {
    try {
      return await body(api.GET("/readyz", { signal }));
    } catch (error) {
      if (error instanceof ApiError && isReadiness(error.problem)) return { ...error.problem, status: "down" };
      throw error;
    }
  },
  refetchInterval: 10_000,
});

function isReadiness(problem: unknown): problem is Pick<Readiness, "checks"> {
  return typeof problem === "object" && problem !== null && "checks" in problem;
}

export const usageQuery = queryOptions({
  queryKey: keys.usage,
  queryFn: ({ signal }) => body(api.GET("/v1/usage", { signal })),
  refetchInterval: 5_000,
});

export const jobsQuery = (filter: JobFilter) =>
  queryOptions({
    queryKey: keys.jobs(filter),
    queryFn: ({ signal }) =>
      body(
        api.GET("/v1/jobs", {
          params: {
            query: {
              limit: PAGE_SIZE,
              ...(filter.state ? { state: filter.state } : {}),
              ...(filter.kind ? { kind: filter.kind } : {}),
              ...(filter.name ? { name: filter.name } : {}),
              ...(filter.order ? { order: filter.order } : {}),
              ...(filter.cursor ? { cursor: filter.cursor } : {}),
              ...(filter.batch ? { batch_id: filter.batch } : {}),
            },
          },
          signal,
        }),
      ),
  });

export const jobQuery = (id: string) =>
  queryOptions({
    queryKey: keys.job(id),
    queryFn: ({ signal }) =>
      body(
        api.GET("/v1/jobs/{job_id}", {
          params: { path: { job_id: id } },
          signal,
        }),
      ),
    // An answer may be older than an event that came while it was on its way.
    structuralSharing: (before, now) =>
      isJob(before) && isJob(now) && before.event > now.event ? before : replaceEqualDeep(before, now),
  });

const isJob = (data: unknown): data is Job => data !== null && typeof data === "object" && "event" in data;

export const assetsQuery = (kind: Asset["kind"]) =>
  queryOptions({
    queryKey: keys.assets(kind),
    queryFn: ({ signal }) => body(api.GET("/v1/assets", { params: { query: { kind, limit: 100 } }, signal })),
  });

export const volumesQuery = assetsQuery("volume");

export const assetQuery = (id: string) =>
  queryOptions({
    queryKey: keys.asset(id),
    queryFn: ({ signal }) =>
      body(
        api.GET("/v1/assets/{asset_id}", {
          params: { path: { asset_id: id } },
          signal,
        }),
      ),
    staleTime: Number.POSITIVE_INFINITY, // an asset never changes
  });

/** The files that a job was started with, by id. */
export function useAssetNames(ids: readonly string[]): ReadonlyMap<string, Asset> {
  const client = useQueryClient();
  const wanted = [...new Set(ids)].sort();
  const { data } = useQuery({
    queryKey: ["assets", "names", wanted],
    enabled: wanted.length > 0,
    staleTime: Number.POSITIVE_INFINITY,
    queryFn: async () => {
      const found = await Promise.all(
        wanted.map((id) => client.query(assetQuery(id)).catch(() => null)), // deleted: the job still has its id
      );
      return new Map(found.filter((asset) => asset !== null).map((asset) => [asset.id, asset]));
    },
    placeholderData: (previous) => previous,
  });
  return data ?? NO_ASSETS;
}

const NO_ASSETS: ReadonlyMap<string, Asset> = new Map();

export function rememberAssets(client: QueryClient, assets: readonly Asset[]): void {
  for (const asset of assets) client.setQueryData(keys.asset(asset.id), asset);
}

export function useCreateJob() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: ({ request, idempotencyKey }: { request: JobCreate; idempotencyKey: string }) =>
      body(
        api.POST("/v1/jobs", {
          body: request,
          params: { header: { "Idempotency-Key": idempotencyKey } },
        }),
      ) as Promise<Job>,
    onSuccess: (job) => {
      client.setQueryData(keys.job(job.id), job);
      void client.invalidateQueries({ queryKey: keys.jobLists });
    },
  });
}

export function useJobAction() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: ({ id, action }: { id: string; action: "cancel" | "retry" }) => {
      const params = { path: { job_id: id } };
      return action === "cancel"
        ? body(api.POST("/v1/jobs/{job_id}/cancel", { params }))
        : body(api.POST("/v1/jobs/{job_id}/retry", { params }));
    },
    onSuccess: (job) => replaceJob(client, job),
    // A refusal mostly means that the job has moved on: show how it is now.
    onSettled: (_job, _error, { id }) => {
      void client.invalidateQueries({ queryKey: keys.job(id) });
      void client.invalidateQueries({ queryKey: keys.jobLists });
    },
  });
}

type JobPage = { items: Job[]; next_cursor?: string | null };

function updateJob(client: QueryClient, id: string, change: (job: Job) => Job): void {
  client.setQueryData<Job>(keys.job(id), (job) => job && change(job));
  client.setQueriesData<JobPage>({ queryKey: keys.jobLists }, (page) => {
    if (!page?.items.some((job) => job.id === id)) return page;
    return {
      ...page,
      items: page.items.map((job) => (job.id === id ? change(job) : job)),
    };
  });
}

function replaceJob(client: QueryClient, job: Job): void {
  client.setQueryData(keys.job(job.id), job);
  updateJob(client, job.id, () => job);
}

/** Put what an event tells into every cached copy of its job, and fetch it anew where the event tells too little. */
export function applyEvent(client: QueryClient, event: JobEvent): void {
  const before = client.getQueryData<Job>(keys.job(event.job_id));
  updateJob(client, event.job_id, (job) => mergeEvent(job, event));
  if (event.type === "state" && before?.state !== event.state) {
    void client.invalidateQueries({ queryKey: keys.job(event.job_id) });
    void client.invalidateQueries({ queryKey: keys.jobLists });
  }
}

/** Number of the newest event of a job that any cached copy knows of. */
export function newestEvent(client: QueryClient, id: string): number {
  const pages = client.getQueriesData<JobPage>({ queryKey: keys.jobLists });
  const listed = pages.flatMap(([, page]) => page?.items.filter((job) => job.id === id) ?? []);
  return Math.max(0, client.getQueryData<Job>(keys.job(id))?.event ?? 0, ...listed.map((job) => job.event));
}

/** A job follows every event that it does not know of yet. */
export function mergeEvent(job: Job, event: JobEvent): Job {
  if (event.seq <= job.event) return job;
  return {
    ...job,
    event: event.seq,
    state: event.state,
    stage: event.stage,
    fraction: event.fraction,
    message: event.message,
    preview: event.preview,
  };
}
