import { Box, Button, Group, Progress, SegmentedControl, Select, Table, Text } from "@mantine/core";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { getRouteApi, useNavigate } from "@tanstack/react-router";
import { ArrowLeft, ArrowRight, ListChecks, Upload } from "lucide-react";
import { useState } from "react";
import { jobsQuery, useAssetNames } from "@/api/queries";
import { type Asset, isTerminal, JOB_STATES, type Job, type JobState } from "@/api/types";
import { useLiveJobs } from "@/api/useLiveJobs";
import { LinkAnchor, LinkButton } from "@/app/links";
import { Empty, Failure, Waiting } from "@/app/Notice";
import { Page } from "@/app/Page";
import { useNow } from "@/app/useNow";
import { ago, duration, moment, percent } from "@/format/format";
import { JobActions } from "./JobActions";
import classes from "./jobs.module.css";
import { jobName, mainInput, outcome } from "./naming";
import { StateBadge } from "./StateBadge";

/** A browser opens six connections to a host: two may stay open for events, the rest is for everything else. */
const STREAMS = 2;
const FILTERS = ["all", ...JOB_STATES.filter((state) => state !== "cancelling")] as const;

const route = getRouteApi("/jobs");

export function JobsPage() {
  const search = route.useSearch();
  const navigate = useNavigate({ from: "/jobs" });
  const jobs = useQuery({
    ...jobsQuery(search),
    placeholderData: keepPreviousData,
    refetchInterval: ({ state }) => (state.data?.items.some((job) => !isTerminal(job.state)) ? 2_000 : 5_000),
  });
  const items = jobs.data?.items ?? [];
  const active = items.filter((job) => !isTerminal(job.state));
  const running = active.filter((job) => job.state !== "queued");
  useLiveJobs([...running, ...active.filter((job) => job.state === "queued")].slice(0, STREAMS).map((job) => job.id));
  const assets = useAssetNames(items.flatMap((job) => mainInput(job) ?? []));
  // Where the pages before this one began, for the way back; a page opened by its address knows only the first.
  const [trail, setTrail] = useState<readonly (string | undefined)[]>([]);

  const filter = (value: string) => {
    setTrail([]);
    void navigate({
      search: value === "all" ? {} : { state: value as JobState },
    });
  };
  const older = () => {
    setTrail([...trail, search.cursor]);
    void navigate({
      search: { ...search, cursor: jobs.data?.next_cursor ?? undefined },
    });
  };
  const newer = () => {
    const cursor = trail.at(-1);
    setTrail(trail.slice(0, -1));
    void navigate({
      search: { ...(search.state ? { state: search.state } : {}), ...(cursor ? { cursor } : {}) },
    });
  };

  return (
    <Page
      title="Jobs"
      actions={
        <LinkButton to="/upload" leftSection={<Upload size={16} aria-hidden="true" />}>
          Upload and segment
        </LinkButton>
      }
    >
      <SegmentedControl
        visibleFrom="sm"
        size="sm"
        mb="md"
        aria-label="Show jobs that are"
        data={FILTERS.map((value) => ({
          value,
          label: value === "all" ? "All" : capital(value),
        }))}
        value={search.state ?? "all"}
        onChange={filter}
      />
      <Select
        hiddenFrom="sm"
        mb="md"
        aria-label="Show jobs that are"
        data={FILTERS.map((value) => ({
          value,
          label: value === "all" ? "All states" : capital(value),
        }))}
        allowDeselect={false}
        value={search.state ?? "all"}
        onChange={(value) => filter(value ?? "all")}
      />
      {jobs.isPending ? (
        <Waiting label="Loading the jobs…" />
      ) : jobs.isError && !jobs.data ? (
        <Failure error={jobs.error} onRetry={() => void jobs.refetch()} />
      ) : items.length === 0 ? (
        <NoJobs filtered={search.state !== undefined} paged={search.cursor !== undefined} />
      ) : (
        <JobTable jobs={items} assets={assets} stale={jobs.isPlaceholderData} />
      )}
      {(search.cursor || jobs.data?.next_cursor) && (
        <Group justify="space-between" mt="md" component="nav" aria-label="Pages of jobs">
          <Button
            variant="default"
            size="sm"
            leftSection={<ArrowLeft size={16} aria-hidden="true" />}
            disabled={!search.cursor}
            onClick={newer}
          >
            {trail.length > 0 || !search.cursor ? "Newer" : "Newest"}
          </Button>
          <Button
            variant="default"
            size="sm"
            rightSection={<ArrowRight size={16} aria-hidden="true" />}
            disabled={!jobs.data?.next_cursor || jobs.isPlaceholderData}
            onClick={older}
          >
            Older
          </Button>
        </Group>
      )}
    </Page>
  );
}

function capital(word: string): string {
  return word.charAt(0).toUpperCase() + word.slice(1);
}

function NoJobs({ filtered, paged }: { filtered: boolean; paged: boolean }) {
  if (filtered || paged) {
    return (
      <Empty icon={<ListChecks size={32} />} title={paged ? "No older jobs" : "No job is in this state"}>
        <LinkButton to="/jobs" variant="default" mt="sm">
          Show all jobs
        </LinkButton>
      </Empty>
    );
  }
  return (
    <Empty icon={<ListChecks size={32} />} title="No jobs yet">
      <Text c="dimmed" size="sm">
        Upload a contrast-enhanced T1 volume, and Shapery finds the tumor's surface in it. You will see it here while it
        runs.
      </Text>
      <LinkButton to="/upload" mt="sm" leftSection={<Upload size={16} aria-hidden="true" />}>
        Upload a volume
      </LinkButton>
    </Empty>
  );
}

interface JobTableProps {
  jobs: readonly Job[];
  assets: ReadonlyMap<string, Asset>;
  /** Whether these are still those of the page or filter before. */
  stale: boolean;
}

function JobTable({ jobs, assets, stale }: JobTableProps) {
  const now = useNow(jobs.some((job) => !isTerminal(job.state)) ? 1_000 : 30_000);
  return (
    <Box className={classes.frame} aria-busy={stale}>
      <Table highlightOnHover verticalSpacing="sm" horizontalSpacing="md" className={classes.table ?? ""}>
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Job</Table.Th>
            <Table.Th w={130}>State</Table.Th>
            <Table.Th w="36%">Progress and outcome</Table.Th>
            <Table.Th w={116} visibleFrom="md">
              Took
            </Table.Th>
            <Table.Th w={120} visibleFrom="sm">
              Created
            </Table.Th>
            <Table.Th w={110}>
              <span className={classes.unseen}>Actions</span>
            </Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {jobs.map((job) => (
            <JobRow key={job.id} job={job} name={jobName(job, assets)} now={now} />
          ))}
        </Table.Tbody>
      </Table>
    </Box>
  );
}

function JobRow({ job, name, now }: { job: Job; name: string; now: number }) {
  const ended = job.finished_at ? Date.parse(job.finished_at) : now;
  return (
    <Table.Tr data-job={job.id} className={classes.row ?? ""}>
      <Table.Td>
        <LinkAnchor
          to="/jobs/$jobId"
          params={{ jobId: job.id }}
          fw={600}
          c="var(--mantine-color-text)"
          className={classes.name ?? ""}
          title={name}
        >
          {name}
        </LinkAnchor>
        <Text size="xs" c="dimmed">
          {capital(job.kind)}
          {job.attempt > 1 ? ` · attempt ${job.attempt}` : ""}
        </Text>
      </Table.Td>
      <Table.Td>
        <StateBadge state={job.state} />
      </Table.Td>
      <Table.Td>
        <Outcome job={job} name={name} />
      </Table.Td>
      <Table.Td visibleFrom="md">
        <Text size="sm">{job.started_at ? duration((ended - Date.parse(job.started_at)) / 1000) : "–"}</Text>
      </Table.Td>
      <Table.Td visibleFrom="sm">
        <Text size="sm" c="dimmed" title={moment(job.created_at)}>
          {ago(job.created_at, now)}
        </Text>
      </Table.Td>
      <Table.Td ta="right">
        <JobActions job={job} name={name} compact />
      </Table.Td>
    </Table.Tr>
  );
}

function Outcome({ job, name }: { job: Job; name: string }) {
  if (job.error) {
    return (
      <>
        <Text size="sm">{job.error.message}</Text>
        {job.error.hint && (
          <Text size="xs" c="dimmed">
            {job.error.hint}
          </Text>
        )}
      </>
    );
  }
  if (job.state === "running" || job.state === "cancelling") {
    return (
      <>
        <Group justify="space-between" gap="xs" wrap="nowrap">
          <Text size="sm" truncate>
            {job.stage ? capital(job.stage) : "Starting"}
            {job.message ? (
              <Text span size="sm" c="dimmed">
                {" "}
                · {job.message}
              </Text>
            ) : null}
          </Text>
          <Text size="sm" c="dimmed">
            {percent(job.fraction)}
          </Text>
        </Group>
        <Progress
          value={job.fraction * 100}
          size={5}
          mt={5}
          aria-label={`${name}: ${percent(job.fraction)}`}
          transitionDuration={200}
        />
      </>
    );
  }
  return (
    <Text size="sm" c={job.expired || job.state !== "succeeded" ? "dimmed" : undefined}>
      {job.state === "queued" ? "Waiting for a worker" : outcome(job)}
    </Text>
  );
}
