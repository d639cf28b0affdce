import { Button, Group, Paper, SegmentedControl, Stack, Text, Title } from "@mantine/core";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { getRouteApi } from "@tanstack/react-router";
import { Download, RotateCcw, X } from "lucide-react";
import { useEffect, useState } from "react";
import { batchQuery, useBatchAction } from "@/api/batches";
import { jobsQuery } from "@/api/queries";
import type { Batch, JobOrder, JobState } from "@/api/types";
import { LinkAnchor, LinkButton } from "@/app/links";
import { Failure, Waiting } from "@/app/Notice";
import { One } from "@/app/One";
import { Page } from "@/app/Page";
import { sayFailure } from "@/app/say";
import { useNow } from "@/app/useNow";
import { JobTable } from "@/features/jobs/JobTable";
import { NEWEST_FIRST, pageNames } from "@/features/jobs/sorting";
import { SaveLink } from "@/features/jobs/SaveLink";
import { ago, capital, moment } from "@/format/format";
import { BatchProgress } from "./BatchProgress";
import { batchName, count, troubled } from "./naming";

const route = getRouteApi("/batches/$batchId");
const SHOWN = ["running", "queued", "succeeded", "failed", "crashed", "cancelled"] as const satisfies JobState[];

export function BatchPage() {
  const { batchId } = route.useParams();
  const batch = useQuery({
    ...batchQuery(batchId),
    refetchInterval: ({ state }) => (state.data?.finished ? false : 1_000),
  });
  return (
    <One
      query={batch}
      what="batch"
      missing="Its address may be mistyped, or it belongs to another key."
      back={
        <LinkButton to="/batches" variant="default" mt="sm">
          To the batches
        </LinkButton>
      }
    >
      {(found) => <LoadedBatch batch={found} />}
    </One>
  );
}

function LoadedBatch({ batch }: { batch: Batch }) {
  const act = useBatchAction(batch.id);
  const now = useNow(10_000);
  const bad = troubled(batch);
  const run = (action: "cancel" | "retry", title: string) =>
    act.mutate(action, { onError: (error) => sayFailure(title, error) });
  return (
    <Page
      title={batchName(batch)}
      trail={
        <LinkAnchor to="/batches" size="sm">
          Batches
        </LinkAnchor>
      }
      lead={
        <span title={moment(batch.created_at)}>
          created {ago(batch.created_at, now)}
          {batch.finished_at ? `, ended ${ago(batch.finished_at, now)}` : ""}
        </span>
      }
      actions={
        <Group gap="sm">
          {bad > 0 && (
            <Button
              size="sm"
              leftSection={<RotateCcw size={15} aria-hidden="true" />}
              loading={act.isPending}
              onClick={() => run("retry", "Not started again")}
            >
              Retry {bad === 1 ? "the failed one" : `the ${bad} failed`}
            </Button>
          )}
          {!batch.finished && (
            <Button
              size="sm"
              variant="default"
              leftSection={<X size={15} aria-hidden="true" />}
              loading={act.isPending}
              onClick={() => run("cancel", "Not cancelled")}
            >
              Cancel what has not ended
            </Button>
          )}
        </Group>
      }
    >
      <Stack gap="lg">
        <Paper p="lg">
          <BatchProgress batch={batch} large />
          <Group gap={6} mt="md">
            <Download size={14} aria-hidden="true" />
            <SaveLink url={`/v1/batches/${batch.id}/results`} name={`batch-${batch.id}.ndjson`}>
              All results as NDJSON, one job a line
            </SaveLink>
          </Group>
        </Paper>
        <BatchJobs batch={batch} />
      </Stack>
    </Page>
  );
}

/** The batch's jobs; what failed comes first where anything did. */
function BatchJobs({ batch }: { batch: Batch }) {
  const [asked, setAsked] = useState<JobState | "all" | null>(null);
  const [order, setOrder] = useState<JobOrder>(NEWEST_FIRST);
  const [cursors, setCursors] = useState<readonly string[]>([]);
  const reorder = (order: JobOrder) => {
    setOrder(order);
    setCursors([]);
  };
  const worst = count(batch, "failed") > 0 ? "failed" : count(batch, "crashed") > 0 ? "crashed" : "all";
  const shown = asked ?? (batch.finished ? worst : "all");
  const jobs = useQuery({
    ...jobsQuery({ batch: batch.id, ...(shown === "all" ? {} : { state: shown }), order, cursor: cursors.at(-1) }),
    placeholderData: keepPreviousData,
    refetchInterval: batch.finished ? false : 2_000,
  });
  // The last job ends between two looks at the list: look once more.
  const { refetch } = jobs;
  useEffect(() => {
    void refetch({ cancelRefetch: false });
  }, [batch.finished, refetch]);
  const items = jobs.data?.items ?? [];
  const next = jobs.data?.next_cursor;
  const states = SHOWN.filter((state) => count(batch, state) > 0 || state === shown);
  return (
    <section aria-labelledby="jobs">
      <Group justify="space-between" mb="sm">
        <Title order={2} id="jobs">
          Jobs
        </Title>
        <SegmentedControl
          size="xs"
          aria-label="Show jobs that are"
          data={[
            { value: "all", label: `All ${batch.total}` },
            ...states.map((state) => ({ value: state, label: `${capital(state)} ${count(batch, state)}` })),
          ]}
          value={shown}
          onChange={(value) => {
            setAsked(value);
            setCursors([]);
          }}
        />
      </Group>
      {jobs.isPending ? (
        <Waiting label="Loading the jobs…" />
      ) : jobs.isError && !jobs.data ? (
        <Failure error={jobs.error} onRetry={() => void jobs.refetch()} />
      ) : items.length === 0 ? (
        <Text size="sm" c="dimmed" py="lg">
          No job of this batch is in this state any more.
        </Text>
      ) : (
        <JobTable jobs={items} order={order} onOrder={reorder} stale={jobs.isPlaceholderData} />
      )}
      {(cursors.length > 0 || next) && (
        <Group justify="space-between" mt="md">
          <Button
            variant="default"
            size="sm"
            disabled={cursors.length === 0}
            onClick={() => setCursors(cursors.slice(0, -1))}
          >
            {pageNames(order).before}
          </Button>
          <Button variant="default" size="sm" disabled={!next} onClick={() => next && setCursors([...cursors, next])}>
            {pageNames(order).after}
          </Button>
        </Group>
      )}
    </section>
  );
}
