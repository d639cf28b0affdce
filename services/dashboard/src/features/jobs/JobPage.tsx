import { Group, Paper, Progress, Stack, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { getRouteApi } from "@tanstack/react-router";
import { CircleAlert, Clock, FileCheck } from "lucide-react";
import { lazy, Suspense } from "react";
import { jobQuery, kindsQuery, useAssetNames } from "@/api/queries";
import { type Asset, isTerminal, type Job } from "@/api/types";
import { useLiveJobs } from "@/api/useLiveJobs";
import { LinkAnchor, LinkButton } from "@/app/links";
import { Empty, Waiting } from "@/app/Notice";
import { One } from "@/app/One";
import { Page } from "@/app/Page";
import { useNow } from "@/app/useNow";
import { isMotionResult } from "@/features/motion/result";
import { isSearchResult } from "@/features/shapes/result";
import { SimilarSurfaces, type SurfaceToFind } from "@/features/shapes/SimilarSurfaces";
import { isSegmentationResult } from "@/features/segmentation/params";
import { AsCode } from "@/features/snippets/AsCode";
import { resultSnippets } from "@/features/snippets/snippets";
import { ago, duration, moment, percent, relative } from "@/format/format";
import { Downloads } from "./Downloads";
import { Expired } from "./Expired";
import { JobActions } from "./JobActions";
import { JobFacts } from "./JobFacts";
import classes from "./jobs.module.css";
import { jobName, mainInput, secondsSpent, workName } from "./naming";
import { StagePath } from "./StagePath";
import { StageTimes } from "./StageTimes";
import { StateBadge } from "./StateBadge";

const ShapeJob = lazy(() => import("@/features/shapes/ShapeJob"));
const MotionView = lazy(() => import("@/features/motion/MotionView"));
const LiveSurface = lazy(() => import("@/features/segmentation/LiveSurface"));
const SegmentationView = lazy(() => import("@/features/segmentation/SegmentationView"));

const route = getRouteApi("/jobs/$jobId");

export function JobPage() {
  const { jobId } = route.useParams();
  const job = useQuery({
    ...jobQuery(jobId),
    // Events say when something has changed; asking now and then mends what they may have missed.
    refetchInterval: ({ state }) => (state.data && !isTerminal(state.data.state) ? 5_000 : false),
  });
  return (
    <One
      query={job}
      what="job"
      missing="Its address may be mistyped, or it belongs to another key."
      back={
        <LinkButton to="/jobs" variant="default" mt="sm">
          To the jobs
        </LinkButton>
      }
    >
      {(found) => <LoadedJob key={jobId} job={found} />}
    </One>
  );
}

function LoadedJob({ job }: { job: Job }) {
  const mode = useLiveJobs(isTerminal(job.state) ? [] : [job.id]);
  useQuery({
    ...jobQuery(job.id),
    enabled: mode === "poll" && !isTerminal(job.state),
    refetchInterval: 1_500,
  });
  const assets = useAssetNames(Object.values(job.inputs).flatMap((ids) => ids.slice(0, 1)));
  const name = jobName(job);
  return (
    <Page
      title={name}
      trail={[
        <LinkAnchor key="jobs" to="/jobs" size="sm">
          Jobs
        </LinkAnchor>,
        <span key="kind">{workName(job.kind)}</span>,
      ]}
      lead={<Lead job={job} />}
      actions={
        <Group gap="sm">
          <JobActions job={job} name={name} />
          {isTerminal(job.state) && job.kind === "segmentation" && (
            <LinkButton to="/upload" search={again(job)} variant="default" size="sm">
              Segment again
            </LinkButton>
          )}
        </Group>
      }
    >
      <Body job={job} assets={assets} />
    </Page>
  );
}

function again(job: Job): { post?: string; pre?: string; vessels?: string } {
  const post = job.inputs.post?.[0];
  const pre = job.inputs.pre?.[0];
  const vessels = job.inputs.vessels?.[0];
  return { ...(post ? { post } : {}), ...(pre ? { pre } : {}), ...(vessels ? { vessels } : {}) };
}

function Lead({ job }: { job: Job }) {
  const now = useNow(isTerminal(job.state) ? 30_000 : 1_000);
  const spent = secondsSpent(job, now);
  const parts = [
    <span key="created" title={moment(job.created_at)}>
      created {ago(job.created_at, now)}
    </span>,
  ];
  if (spent !== null) {
    const word = job.finished_at ? "took" : "running for";
    parts.push(
      <span key="took">
        {word} {duration(spent)}
      </span>,
    );
  }
  if (job.attempt > 1) parts.push(<span key="attempt">attempt {job.attempt}</span>);
  if (job.state === "succeeded" && job.expires_at && !job.expired) {
    parts.push(
      <span key="expires" title={moment(job.expires_at)}>
        results kept until {moment(job.expires_at)} ({relative(Date.parse(job.expires_at), now)})
      </span>,
    );
  }
  return (
    <Group component="span" gap={6} mt={2} role="status" wrap="nowrap" align="flex-start">
      <StateBadge state={job.state} />
      <Text span size="sm" c="dimmed" className={classes.facts ?? ""}>
        {parts}
      </Text>
    </Group>
  );
}

function Body({ job, assets }: { job: Job; assets: ReadonlyMap<string, Asset> }) {
  if (!isTerminal(job.state)) return <Underway job={job} assets={assets} />;
  const name = jobName(job);
  // A shape stays when the files of its job have expired.
  if (job.state === "succeeded" && (job.kind === "shape-index" || isSearchResult(job.result))) {
    return (
      <Aside job={job} assets={assets}>
        <Suspense fallback={<Waiting label="Loading the page…" />}>
          <ShapeJob job={job} />
        </Suspense>
      </Aside>
    );
  }
  if (job.state === "succeeded") {
    if (job.expired) {
      return (
        <Aside job={job} assets={assets}>
          <Expired job={job} />
        </Aside>
      );
    }
    if (isSegmentationResult(job.result)) {
      return (
        <Suspense fallback={<Waiting label="Loading the viewers…" />}>
          <SegmentationView
            job={job}
            result={job.result}
            post={assets.get(mainInput(job) ?? "") ?? null}
            facts={
              <>
                <SimilarSurfaces surfaces={surfacesToFind(job, name)} />
                <StageTimes stages={job.result.stages} />
                <JobFacts job={job} assets={assets} />
                <AsCode title="Fetch this as code" of={(target) => resultSnippets(job, target)} />
              </>
            }
          />
        </Suspense>
      );
    }
  }
  if (job.state === "succeeded" && isMotionResult(job.result)) {
    return (
      <Suspense fallback={<Waiting label="Loading the player…" />}>
        <MotionView
          job={job}
          result={job.result}
          facts={
            <>
              <StageTimes stages={job.result.stages} />
              <JobFacts job={job} assets={assets} />
              <AsCode title="Fetch this as code" of={(target) => resultSnippets(job, target)} />
            </>
          }
        />
      </Suspense>
    );
  }
  return (
    <Aside job={job} assets={assets}>
      <Ended job={job} />
    </Aside>
  );
}

/** The surfaces of a segmentation's objects, as examples for a search; `name` is the volume's. */
function surfacesToFind(job: Job, name: string): SurfaceToFind[] {
  if (!isSegmentationResult(job.result)) return [];
  const stem = name.replace(/(\.nii)?\.\w+$/, "");
  return job.result.objects.flatMap(({ label, surface }) => {
    const file = job.artifacts.find((artifact) => artifact.name === surface);
    return file ? [{ title: `object ${label}`, filename: `${stem}-object-${label}.ply`, url: file.url }] : [];
  });
}

function Aside({ job, assets, children }: { job: Job; assets: ReadonlyMap<string, Asset>; children: React.ReactNode }) {
  return (
    <div className={classes.columns}>
      <div>{children}</div>
      <JobFacts job={job} assets={assets} />
    </div>
  );
}

/** Vessels are looked for only where a volume shows them. */
function stagesOf(job: Job, stages: readonly string[]): readonly string[] {
  return stages.filter((stage) => stage !== "vessels" || job.inputs.vessels !== undefined);
}

function Underway({ job, assets }: { job: Job; assets: ReadonlyMap<string, Asset> }) {
  const kinds = useQuery(kindsQuery);
  const kind = kinds.data?.find(({ name }) => name === job.kind);
  return (
    <Aside job={job} assets={assets}>
      <Paper p="lg">
        {kind && <StagePath stages={stagesOf(job, kind.stages)} current={job.state === "queued" ? "" : job.stage} />}
        <Group justify="space-between" mb={6} wrap="nowrap">
          <Text size="sm" truncate aria-live="polite">
            {job.state === "queued"
              ? kind?.workers === 0
                ? "No worker for this kind is running. The job waits for one."
                : "Waiting for a free worker"
              : job.state === "cancelling"
                ? "Stopping…"
                : job.message || "Working…"}
          </Text>
          <Text size="sm" fw={600}>
            {percent(job.fraction)}
          </Text>
        </Group>
        <Progress
          value={job.fraction * 100}
          size="md"
          color={job.state === "cancelling" ? "orange" : "petrol"}
          animated={job.state === "running"}
          transitionDuration={200}
          aria-label={`${percent(job.fraction)} done`}
        />
        <Group gap={6} mt="md">
          <Clock size={14} aria-hidden="true" />
          <Text size="xs" c="dimmed">
            You may leave or reload this page: the job goes on, and this shows how far it is.
          </Text>
        </Group>
      </Paper>
      {(job.kind === "segmentation" || job.preview > 0) && job.state !== "queued" && (
        <Suspense fallback={null}>
          <LiveSurface job={job} />
        </Suspense>
      )}
    </Aside>
  );
}

function Ended({ job }: { job: Job }) {
  const crashed = job.state === "crashed";
  const cancelled = job.state === "cancelled";
  if (cancelled || !job.error) {
    const files = job.artifacts.length > 0;
    return (
      <Stack gap="md">
        <Paper>
          <Empty
            icon={cancelled ? <CircleAlert size={32} /> : <FileCheck size={32} />}
            title={cancelled ? "The job was cancelled" : files ? "Done" : "There is nothing to show"}
          >
            <Text size="sm" c="dimmed">
              {cancelled
                ? "It left no results. Retry runs it again with the same input."
                : files
                  ? "What it made is in its files."
                  : "The job has ended without a result."}
            </Text>
          </Empty>
        </Paper>
        <Downloads artifacts={job.artifacts} />
      </Stack>
    );
  }
  return (
    <Paper p="xl" role="alert" data-testid="job-error">
      <Group align="flex-start" wrap="nowrap" gap="md">
        <CircleAlert
          size={26}
          style={{ flexShrink: 0 }}
          color={`var(--mantine-color-${crashed ? "grape" : "red"}-6)`}
          aria-hidden="true"
        />
        <Stack gap="xs">
          <Text fw={600} size="lg">
            {job.error.message}
          </Text>
          {job.error.hint && !crashed && <Text>{job.error.hint}</Text>}
          <Text size="sm" c="dimmed">
            {crashed
              ? "The fault is on the server's side, and it was logged. Retry runs it again with the same input."
              : job.kind === "segmentation"
                ? "Retry runs it again as it was; Segment again lets you change the input or the parameters."
                : "Retry runs it again as it was."}
          </Text>
          <Text size="xs" c="dimmed" ff="monospace">
            {job.error.code}
            {job.stage ? ` · in stage ${job.stage}` : ""}
          </Text>
        </Stack>
      </Group>
    </Paper>
  );
}
