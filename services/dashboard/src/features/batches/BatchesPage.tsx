import { Group, Table, Text } from "@mantine/core";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { getRouteApi } from "@tanstack/react-router";
import { Layers, Plus } from "lucide-react";
import { batchesQuery } from "@/api/batches";
import type { Batch } from "@/api/types";
import { LinkAnchor, LinkButton } from "@/app/links";
import { Empty, Failure, Waiting } from "@/app/Notice";
import { Page } from "@/app/Page";
import { useNow } from "@/app/useNow";
import jobs from "@/features/jobs/jobs.module.css";
import { ago, integer, moment } from "@/format/format";
import { BatchProgress } from "./BatchProgress";
import { batchName } from "./naming";

const route = getRouteApi("/batches");

export function BatchesPage() {
  const { cursor } = route.useSearch();
  const batches = useQuery({
    ...batchesQuery(cursor),
    placeholderData: keepPreviousData,
    refetchInterval: ({ state }) => (state.data?.items.some(({ finished }) => !finished) ? 2_000 : 15_000),
  });
  const items = batches.data?.items ?? [];
  return (
    <Page
      title="Batches"
      actions={
        <LinkButton to="/batches/new" leftSection={<Plus size={16} aria-hidden="true" />}>
          New batch
        </LinkButton>
      }
    >
      {batches.isPending ? (
        <Waiting label="Loading the batches…" />
      ) : batches.isError && !batches.data ? (
        <Failure error={batches.error} onRetry={() => void batches.refetch()} />
      ) : items.length === 0 ? (
        <Empty icon={<Layers size={32} />} title={cursor ? "No older batches" : "No batches yet"}>
          <Text c="dimmed" size="sm">
            A batch runs the same work on many volumes: one progress, one list of failures, and what failed runs again
            alone.
          </Text>
          <LinkButton to="/batches/new" mt="sm" leftSection={<Plus size={16} aria-hidden="true" />}>
            Pick volumes
          </LinkButton>
        </Empty>
      ) : (
        <BatchTable batches={items} />
      )}
      {(cursor ?? batches.data?.next_cursor) && (
        <Group justify="space-between" mt="md" component="nav" aria-label="Pages of batches">
          <LinkButton to="/batches" variant="default" size="sm" disabled={!cursor}>
            Newest
          </LinkButton>
          {batches.data?.next_cursor && (
            <LinkButton to="/batches" search={{ cursor: batches.data.next_cursor }} variant="default" size="sm">
              Older
            </LinkButton>
          )}
        </Group>
      )}
    </Page>
  );
}

function BatchTable({ batches }: { batches: readonly Batch[] }) {
  const now = useNow(10_000);
  return (
    <div className={jobs.frame}>
      <Table highlightOnHover verticalSpacing="sm" horizontalSpacing="md" className={jobs.table ?? ""}>
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Batch</Table.Th>
            <Table.Th w="48%">Progress</Table.Th>
            <Table.Th w={150} visibleFrom="sm">
              Created
            </Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {batches.map((batch) => (
            <Table.Tr key={batch.id} data-batch={batch.id}>
              <Table.Td>
                <LinkAnchor
                  to="/batches/$batchId"
                  params={{ batchId: batch.id }}
                  fw={600}
                  c="var(--mantine-color-text)"
                >
                  {batchName(batch)}
                </LinkAnchor>
                <Text size="xs" c="dimmed">
                  {integer(batch.total)} {batch.total === 1 ? "job" : "jobs"}
                </Text>
              </Table.Td>
              <Table.Td>
                <BatchProgress batch={batch} />
              </Table.Td>
              <Table.Td visibleFrom="sm">
                <Text size="sm" c="dimmed" title={moment(batch.created_at)}>
                  {ago(batch.created_at, now)}
                </Text>
              </Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </div>
  );
}
