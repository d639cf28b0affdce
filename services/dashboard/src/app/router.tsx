import { Text } from "@mantine/core";
import { createRootRoute, createRoute, createRouter, lazyRouteComponent } from "@tanstack/react-router";
import { Compass } from "lucide-react";
import { JOB_STATES, type JobOrder, type JobState, type ShapeOrder } from "@/api/types";
import { readAddress } from "@/features/shapes/searching";
import { LinkButton } from "./links";
import { Empty, Failure, Waiting } from "./Notice";
import { Page } from "./Page";
import { Shell } from "./Shell";

/** A collection may well be called 2024. */
const text = (value: unknown): string | undefined =>
  typeof value === "string" || typeof value === "number" ? String(value) : undefined;

const root = createRootRoute({
  component: Shell,
  notFoundComponent: () => (
    <Page title="" tab="Not found">
      <Empty icon={<Compass size={32} />} title="There is no such page">
        <Text c="dimmed" size="sm">
          The address may be mistyped, or the page has moved.
        </Text>
        <LinkButton to="/" variant="default" mt="sm">
          To the start
        </LinkButton>
      </Empty>
    </Page>
  ),
});

const start = createRoute({
  getParentRoute: () => root,
  path: "/",
  component: lazyRouteComponent(() => import("@/features/home/HomePage"), "HomePage"),
});

export interface JobsSearch {
  state?: JobState | undefined;
  kind?: string | undefined;
  name?: string | undefined;
  order?: JobOrder | undefined;
  cursor?: string | undefined;
}

const JOB_ORDERS: readonly unknown[] = ["created", "name", "-name", "state", "-state", "took", "-took"];

export const jobsRoute = createRoute({
  getParentRoute: () => root,
  path: "/jobs",
  validateSearch: (search: Record<string, unknown>): JobsSearch => ({
    ...(JOB_STATES.includes(search.state as JobState) ? { state: search.state as JobState } : {}),
    ...(typeof search.kind === "string" ? { kind: search.kind } : {}),
    ...(text(search.name) === undefined ? {} : { name: text(search.name) }),
    ...(JOB_ORDERS.includes(search.order) ? { order: search.order as JobOrder } : {}),
    ...(typeof search.cursor === "string" ? { cursor: search.cursor } : {}),
  }),
  component: lazyRouteComponent(() => import("@/features/jobs/JobsPage"), "JobsPage"),
});

export const jobRoute = createRoute({
  getParentRoute: () => root,
  path: "/jobs/$jobId",
  component: lazyRouteComponent(() => import("@/features/jobs/JobPage"), "JobPage"),
});

export const uploadRoute = createRoute({
  getParentRoute: () => root,
  path: "/upload",
  validateSearch: (search: Record<string, unknown>): { post?: string; pre?: string; vessels?: string } => ({
    ...(typeof search.post === "string" ? { post: search.post } : {}),
    ...(typeof search.pre === "string" ? { pre: search.pre } : {}),
    ...(typeof search.vessels === "string" ? { vessels: search.vessels } : {}),
  }),
  component: lazyRouteComponent(() => import("@/features/uploads/UploadPage"), "UploadPage"),
});

const batchesRoute = createRoute({
  getParentRoute: () => root,
  path: "/batches",
  validateSearch: (search: Record<string, unknown>): { cursor?: string } =>
    typeof search.cursor === "string" ? { cursor: search.cursor } : {},
  component: lazyRouteComponent(() => import("@/features/batches/BatchesPage"), "BatchesPage"),
});

const newBatchRoute = createRoute({
  getParentRoute: () => root,
  path: "/batches/new",
  component: lazyRouteComponent(() => import("@/features/batches/NewBatchPage"), "NewBatchPage"),
});

const batchRoute = createRoute({
  getParentRoute: () => root,
  path: "/batches/$batchId",
  component: lazyRouteComponent(() => import("@/features/batches/BatchPage"), "BatchPage"),
});

const motionRoute = createRoute({
  getParentRoute: () => root,
  path: "/motion",
  validateSearch: (search: Record<string, unknown>): { sequence?: string } =>
    typeof search.sequence === "string" ? { sequence: search.sequence } : {},
  component: lazyRouteComponent(() => import("@/features/motion/MotionPage"), "MotionPage"),
});

const texts = (value: unknown): string[] => [value].flat().filter((text) => typeof text === "string");

/** Which shapes of the bank are shown. */
export interface ShapesSearch {
  collection?: string | undefined;
  labels?: string[] | undefined;
  name?: string | undefined;
  outdated?: boolean;
  order?: ShapeOrder | undefined;
}

const shapesRoute = createRoute({
  getParentRoute: () => root,
  path: "/shapes",
  validateSearch: ({ collection, labels, name, outdated, order }: Record<string, unknown>): ShapesSearch => ({
    ...(text(collection) === undefined ? {} : { collection: text(collection) }),
    labels: texts(labels).length > 0 ? texts(labels) : undefined, // also where the address has something else
    ...(text(name) === undefined ? {} : { name: text(name) }),
    ...(outdated === true ? { outdated } : {}),
    ...(order === "created" || order === "name" || order === "-name" ? { order } : {}),
  }),
  component: lazyRouteComponent(() => import("@/features/shapes/ShapesPage"), "ShapesPage"),
});

const shapeSearchRoute = createRoute({
  getParentRoute: () => root,
  path: "/shapes/search",
  validateSearch: readAddress,
  component: lazyRouteComponent(() => import("@/features/shapes/SearchPage"), "SearchPage"),
});

const shapeRoute = createRoute({
  getParentRoute: () => root,
  path: "/shapes/$shapeId",
  component: lazyRouteComponent(() => import("@/features/shapes/ShapePage"), "ShapePage"),
});

const settingsRoute = createRoute({
  getParentRoute: () => root,
  path: "/settings",
  component: lazyRouteComponent(() => import("@/features/settings/SettingsPage"), "SettingsPage"),
});

export const router = createRouter({
  routeTree: root.addChildren([
    start,
    jobsRoute,
    jobRoute,
    uploadRoute,
    batchesRoute,
    newBatchRoute,
    batchRoute,
    motionRoute,
    shapesRoute,
    shapeSearchRoute,
    shapeRoute,
    settingsRoute,
  ]),
  defaultPreload: "intent",
  scrollRestoration: true,
  defaultPendingComponent: () => <Waiting label="Loading…" />,
  defaultErrorComponent: ({ error, reset }) => (
    <Page title="Something broke" tab="Error">
      <Failure error={error} onRetry={reset} />
    </Page>
  ),
});

declare module "@tanstack/react-router" {
  interface Register {
    router: typeof router;
  }
}
