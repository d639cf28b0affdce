import { Alert, Button, Checkbox, Group, Paper, Select, Stack, Table, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useNavigate } from "@tanstack/react-router";
import { Box, Upload } from "lucide-react";
import { useMemo, useState } from "react";
import { useCreateBatch } from "@/api/batches";
import { Attempts } from "@/api/idempotency";
import { infoQuery, kindsQuery, volumesQuery } from "@/api/queries";
import type { Asset, BatchCreate } from "@/api/types";
import { LinkButton } from "@/app/links";
import { Empty, Failure, Waiting } from "@/app/Notice";
import { Page } from "@/app/Page";
import { useStore } from "@/app/store";
import jobs from "@/features/jobs/jobs.module.css";
import { type Pair, pairUp } from "@/features/segmentation/roles";
import { AsCode } from "@/features/snippets/AsCode";
import { batchSnippets } from "@/features/snippets/snippets";
import { uploads } from "@/features/uploads/uploads";
import { describeAsset } from "@/format/asset";
import { integer } from "@/format/format";
import classes from "./batches.module.css";

type Chosen = ReadonlyMap<string, string | null>;

/** Picks the volumes of a batch: each one after contrast, with the one before where there is one. */
export function NewBatchPage() {
  const volumes = useQuery(volumesQuery);
  return (
    <Page title="New batch" lead="Tick the volumes made after contrast. Each becomes one segmentation.">
      {volumes.isPending ? (
        <Waiting label="Loading the volumes…" />
      ) : volumes.isError && !volumes.data ? (
        <Failure error={volumes.error} onRetry={() => void volumes.refetch()} />
      ) : volumes.data.items.length === 0 ? (
        <Empty icon={<Box size={32} />} title="No volumes yet">
          <Text c="dimmed" size="sm">
            Drop a folder of volumes on the upload page; they can be picked here as soon as they are on the server.
          </Text>
          <LinkButton to="/upload" mt="sm" leftSection={<Upload size={16} aria-hidden="true" />}>
            Upload volumes
          </LinkButton>
        </Empty>
      ) : (
        <Picker volumes={volumes.data.items} more={Boolean(volumes.data.next_cursor)} />
      )}
    </Page>
  );
}

function Picker({ volumes, more }: { volumes: readonly Asset[]; more: boolean }) {
  const navigate = useNavigate();
  const kinds = useQuery(kindsQuery);
  const info = useQuery(infoQuery);
  const create = useCreateBatch();
  const items = useStore(uploads.items);
  const pairs = useMemo(() => new Map(pairUp(volumes).map(({ post, pre }) => [post, pre])), [volumes]);
  // What was uploaded just now is most likely meant.
  const [chosen, setChosen] = useState<Chosen>(() => {
    const recent = new Set(items.flatMap(({ assetId }) => assetId ?? []));
    return new Map([...pairs].filter(([post]) => recent.has(post)));
  });
  const [attempts] = useState(() => new Attempts());
  const kind = kinds.data?.find(({ name }) => name === "segmentation");
  const limit = info.data?.max_batch_items ?? Number.POSITIVE_INFINITY;
  const before = new Set(chosen.values());
  const request = requestFor(volumes, chosen);
  const paired = [...chosen.values()].filter(Boolean).length;

  const choose = (id: string, on: boolean) => {
    const next = new Map(chosen);
    if (on) next.set(id, pairs.get(id) ?? null);
    else next.delete(id);
    setChosen(next);
  };

  return (
    <div className={classes.columns}>
      <section aria-labelledby="volumes">
        <Group justify="space-between" mb="sm">
          <Title order={2} id="volumes">
            Volumes on the server
          </Title>
          <Group gap="xs">
            <Button size="compact-sm" variant="default" disabled={pairs.size === 0} onClick={() => setChosen(pairs)}>
              All that say “after contrast” ({pairs.size})
            </Button>
            <Button
              size="compact-sm"
              variant="default"
              disabled={chosen.size === 0}
              onClick={() => setChosen(new Map())}
            >
              None
            </Button>
          </Group>
        </Group>
        <div className={jobs.frame}>
          <Table verticalSpacing="xs" horizontalSpacing="md" className={jobs.table ?? ""}>
            <Table.Thead>
              <Table.Tr>
                <Table.Th w={52}>
                  <span className={jobs.unseen}>Segment</span>
                </Table.Th>
                <Table.Th>Volume</Table.Th>
                <Table.Th w="42%">Before contrast</Table.Th>
              </Table.Tr>
            </Table.Thead>
            <Table.Tbody>
              {volumes.map((volume) => (
                <Table.Tr key={volume.id} data-volume={volume.filename}>
                  <Table.Td>
                    <Checkbox
                      aria-label={`Segment ${volume.filename}`}
                      checked={chosen.has(volume.id)}
                      disabled={before.has(volume.id)}
                      onChange={(event) => choose(volume.id, event.currentTarget.checked)}
                    />
                  </Table.Td>
                  <Table.Td>
                    <Text size="sm" fw={550} truncate title={volume.filename}>
                      {volume.filename}
                    </Text>
                    <Text size="xs" c="dimmed" truncate>
                      {describeAsset(volume)}
                    </Text>
                  </Table.Td>
                  <Table.Td>
                    {chosen.has(volume.id) ? (
                      <Select
                        size="xs"
                        aria-label={`Before contrast, for ${volume.filename}`}
                        placeholder="None"
                        clearable
                        searchable
                        data={volumes
                          .filter(({ id }) => id !== volume.id && !chosen.has(id))
                          .map(({ id, filename }) => ({ value: id, label: filename }))}
                        value={chosen.get(volume.id) ?? null}
                        onChange={(id) => setChosen(new Map(chosen).set(volume.id, id))}
                      />
                    ) : before.has(volume.id) ? (
                      <Text size="xs" c="dimmed">
                        goes with the one after contrast
                      </Text>
                    ) : null}
                  </Table.Td>
                </Table.Tr>
              ))}
            </Table.Tbody>
          </Table>
        </div>
        {more && (
          <Text size="xs" c="dimmed" mt="xs">
            The newest 100 volumes are shown. Larger batches are started from the command line or over HTTP.
          </Text>
        )}
      </section>
      <Stack gap="md" className={classes.side ?? ""}>
        <Paper p="lg">
          <Stack gap="sm">
            <Text data-testid="summary">
              {chosen.size === 0
                ? "Nothing is ticked yet."
                : `${integer(chosen.size)} ${chosen.size === 1 ? "volume" : "volumes"}, ${
                    paired === 0 ? "none" : integer(paired)
                  } with one before contrast.`}
            </Text>
            {kind?.workers === 0 && (
              <Alert color="orange" variant="light">
                No worker for segmentation is running at the moment. The jobs will wait for one.
              </Alert>
            )}
            {chosen.size > limit && (
              <Alert color="orange" variant="light">
                This server takes {integer(limit)} jobs in one batch.
              </Alert>
            )}
            {create.isError && <Failure error={create.error} />}
            <Button
              disabled={chosen.size === 0 || chosen.size > limit}
              loading={create.isPending}
              onClick={() =>
                create.mutate(
                  { request, idempotencyKey: attempts.keyFor(request) },
                  {
                    onSuccess: (batch) => void navigate({ to: "/batches/$batchId", params: { batchId: batch.id } }),
                  },
                )
              }
            >
              Segment {chosen.size > 0 ? integer(chosen.size) : ""}
            </Button>
          </Stack>
        </Paper>
        {chosen.size > 0 && <AsCode of={(target) => batchSnippets(request, target)} />}
      </Stack>
    </div>
  );
}

function requestFor(volumes: readonly Asset[], chosen: Chosen): BatchCreate {
  const posts: Pair[] = volumes
    .filter(({ id }) => chosen.has(id))
    .map(({ id }) => ({ post: id, pre: chosen.get(id) ?? null }));
  return {
    kind: "segmentation",
    params: {},
    items: posts.map(({ post, pre }) => ({ inputs: { post, ...(pre ? { pre } : {}) }, params: {} })),
  };
}
