import { CloseButton, Group, Paper, Progress, Stack, Text } from "@mantine/core";
import { type InfiniteData, useQueries, useQueryClient } from "@tanstack/react-query";
import { useEffect } from "react";
import { batchQuery } from "@/api/batches";
import { shapeKeys, type ShapePage } from "@/api/shapes";
import { LinkAnchor } from "@/app/links";
import { useStore } from "@/app/store";
import { count, ended, troubled } from "@/features/batches/naming";
import { uploads } from "@/features/uploads/uploads";
import { integer } from "@/format/format";
import { adding } from "./adder";
import type { Addition } from "./adding";

/** How far the shapes are that are being added. */
export function Additions() {
  const additions = useStore(adding.additions);
  if (additions.length === 0) return null;
  return (
    <Stack gap="xs" mb="md">
      {additions.map((addition) => (
        <Progressing key={addition.id} addition={addition} />
      ))}
    </Stack>
  );
}

function Progressing({ addition }: { addition: Addition }) {
  const client = useQueryClient();
  const items = useStore(uploads.items).filter(({ id }) => addition.uploads.includes(id));
  const batches = useQueries({
    queries: addition.batches.map((id) => ({
      ...batchQuery(id),
      refetchInterval: ({ state }: { state: { data?: { finished: boolean } } }) =>
        state.data?.finished ? (false as const) : 1_000,
    })),
  }).flatMap(({ data }) => data ?? []);
  const indexed = batches.reduce((sum, batch) => sum + count(batch, "succeeded"), 0);
  const over = batches.reduce((sum, batch) => sum + ended(batch), 0);
  const failed = batches.reduce((sum, batch) => sum + troubled(batch), 0);
  const sent = Object.keys(addition.arrived).length + items.filter(({ state }) => state === "failed").length;
  const indexing = addition.batches.length > 0;
  const finished = addition.error !== null || (addition.handedOver && over >= addition.total);

  // What has been indexed appears while the rest is under way; a wall of many pages waits for the end.
  useEffect(() => {
    if (indexed === 0) return;
    const pages = (data: unknown) => (data as InfiniteData<ShapePage> | undefined)?.pages.length ?? 0;
    void client.invalidateQueries({
      queryKey: shapeKeys.lists,
      predicate: ({ state }) => finished || pages(state.data) < 3,
    });
    void client.invalidateQueries({ queryKey: shapeKeys.collections });
    void client.invalidateQueries({ queryKey: ["shapes", "labels"] });
  }, [client, indexed, finished]);

  const says = addition.error
    ? `Not added: ${addition.error}`
    : finished
      ? `${integer(indexed)} of ${integer(addition.total + addition.refused.length)} ${
          addition.again ? "indexed again in" : "added to"
        } ${addition.collection}.`
      : indexing
        ? `Indexing ${addition.again ? "again in" : "for"} ${addition.collection}: ${integer(over)} of ${integer(addition.total)}`
        : `Uploading for ${addition.collection}: ${integer(sent)} of ${integer(addition.total)}`;
  const total = addition.total || 1;
  // Uploading is the smaller part of the way.
  const fraction = indexing ? 0.2 + 0.8 * (over / total) : 0.2 * (sent / total);
  return (
    <Paper p="sm" px="md" component="section" aria-label="Shapes being added" data-finished={finished}>
      <Group justify="space-between" wrap="nowrap" align="flex-start">
        <Text size="sm" fw={550} aria-live="polite" c={addition.error ? "var(--bad)" : undefined}>
          {says}
        </Text>
        <Group gap="xs" wrap="nowrap">
          {indexing && addition.batches[0] && (
            <LinkAnchor to="/batches/$batchId" params={{ batchId: addition.batches[0] }} size="sm">
              {failed > 0 ? `${integer(failed)} failed: why` : "The batch"}
            </LinkAnchor>
          )}
          {finished && <CloseButton size="sm" aria-label="Close" onClick={() => adding.forget(addition.id)} />}
        </Group>
      </Group>
      {!finished && <Progress value={100 * fraction} size="sm" mt={8} aria-label={says} transitionDuration={200} />}
      {addition.refused.map(({ name, why }) => (
        <Text key={name} size="sm" c="dimmed" mt={4}>
          {name}: {why}
        </Text>
      ))}
    </Paper>
  );
}
