import { Box, Button, Group, SegmentedControl, Select, Text } from "@mantine/core";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { getRouteApi, useNavigate } from "@tanstack/react-router";
import { ArrowLeft, ArrowRight, ListChecks, Upload } from "lucide-react";
import { useState } from "react";
import { jobsQuery, kindsQuery } from "@/api/queries";
import { isTerminal, JOB_STATES, type JobState } from "@/api/types";
import { useLiveJobs } from "@/api/useLiveJobs";
import { LinkButton } from "@/app/links";
import { Empty, Failure, Waiting } from "@/app/Notice";
import { NameFilter } from "@/app/NameFilter";
import { Page } from "@/app/Page";
import { given } from "@/app/given";
import type { JobsSearch } from "@/app/router";
import { capital } from "@/format/format";
import { JobTable } from "./JobTable";
import { workName } from "./naming";
import { NEWEST_FIRST, pageNames } from "./sorting";

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
  const kinds = useQuery(kindsQuery);
  const items = jobs.data?.items ?? [];
  const active = items.filter((job) => !isTerminal(job.state));
  const running = active.filter((job) => job.state !== "queued");
  useLiveJobs([...running, ...active.filter((job) => job.state === "queued")].slice(0, STREAMS).map((job) => job.id));
  const filtered = [search.state, search.kind, search.name].some((value) => value !== undefined);
  const some = items.length > 0 || search.cursor !== undefined || jobs.isPlaceholderData; // which may be there to filter
  const order = search.order ?? NEWEST_FIRST;
  const pages = pageNames(order);
  // Where the pages before this one began, for the way back; a page opened by its address knows only the first.
  const [trail, setTrail] = useState<readonly (string | undefined)[]>([]);

  /** Another list begins with its first page. */
  const change = (changed: Partial<JobsSearch>) => {
    setTrail([]);
    void navigate({ search: (before) => given({ ...before, ...changed, cursor: undefined }) });
  };
  const filter = (value: string) => change({ state: value === "all" ? undefined : (value as JobState) });
  const older = () => {
    setTrail([...trail, search.cursor]);
    void navigate({ search: given({ ...search, cursor: jobs.data?.next_cursor ?? undefined }) });
  };
  const newer = () => {
    const cursor = trail.at(-1);
    setTrail(trail.slice(0, -1));
    void navigate({ search: given({ ...search, cursor }) });
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
      {(filtered || some) && (
        <Group mb="md" gap="sm">
          <SegmentedControl
            visibleFrom="sm"
            size="sm"
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
            aria-label="Show jobs that are"
            data={FILTERS.map((value) => ({
              value,
              label: value === "all" ? "All states" : capital(value),
            }))}
            allowDeselect={false}
            value={search.state ?? "all"}
            onChange={(value) => filter(value ?? "all")}
          />
          <Select
            aria-label="Show jobs of one kind"
            placeholder="All kinds"
            size="sm"
            w={150}
            clearable
            data={(kinds.data ?? []).map(({ name }) => ({ value: name, label: workName(name) }))}
            value={search.kind ?? null}
            onChange={(value) => change({ kind: value ?? undefined })}
          />
          <Box flex="1 1 7rem" maw={240}>
            <NameFilter name={search.name} onName={(name) => change({ name })} />
          </Box>
        </Group>
      )}
      {jobs.isPending ? (
        <Waiting label="Loading the jobs…" />
      ) : jobs.isError && !jobs.data ? (
        <Failure error={jobs.error} onRetry={() => void jobs.refetch()} />
      ) : items.length === 0 ? (
        <NoJobs filtered={filtered} paged={search.cursor !== undefined} />
      ) : (
        <JobTable
          jobs={items}
          order={order}
          onOrder={(order) => change({ order: order === NEWEST_FIRST ? undefined : order })}
          stale={jobs.isPlaceholderData}
        />
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
            {trail.length > 0 || !search.cursor ? pages.before : order === NEWEST_FIRST ? "Newest" : "First"}
          </Button>
          <Button
            variant="default"
            size="sm"
            rightSection={<ArrowRight size={16} aria-hidden="true" />}
            disabled={!jobs.data?.next_cursor || jobs.isPlaceholderData}
            onClick={older}
          >
            {pages.after}
          </Button>
        </Group>
      )}
    </Page>
  );
}

function NoJobs({ filtered, paged }: { filtered: boolean; paged: boolean }) {
  if (filtered || paged) {
    return (
      <Empty icon={<ListChecks size={32} />} title={paged ? "No further jobs" : "No job is like that"}>
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
