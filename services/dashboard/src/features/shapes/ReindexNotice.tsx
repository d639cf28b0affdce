import { Alert, Button, Group, Text } from "@mantine/core";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { RotateCw } from "lucide-react";
import { useEffect } from "react";
import { api, body } from "@/api/client";
import { jobQuery } from "@/api/queries";
import { shapeKeys } from "@/api/shapes";
import { isTerminal, type Job, type Shape } from "@/api/types";
import { Failure } from "@/app/Notice";
import { percent } from "@/format/format";

/** The shape was indexed by an older version: no search sees it until it is indexed again. */
export function ReindexNotice({ shape }: { shape: Pick<Shape, "id"> }) {
  const client = useQueryClient();
  const start = useMutation({
    mutationFn: () =>
      body(api.POST("/v1/shapes/{shape_id}/reindex", { params: { path: { shape_id: shape.id } } })) as Promise<Job>,
  });
  const job = useQuery({
    ...jobQuery(start.data?.id ?? ""),
    enabled: start.data !== undefined,
    refetchInterval: ({ state }) => (state.data && isTerminal(state.data.state) ? false : 1_000),
  }).data;
  const over = job !== undefined && isTerminal(job.state);
  useEffect(() => {
    if (!over) return;
    void client.invalidateQueries({ queryKey: shapeKeys.one(shape.id) });
    void client.invalidateQueries({ queryKey: shapeKeys.lists });
  }, [client, over, shape.id]);
  return (
    <Alert color="orange" variant="light" icon={<RotateCw size={18} />}>
      <Group justify="space-between">
        <Text size="sm">
          An older version has indexed this shape. Searches do not see it until it is indexed again.
        </Text>
        {start.isSuccess && !over ? (
          <Text size="sm" role="status">
            Indexing… {percent(job?.fraction ?? 0)}
          </Text>
        ) : (
          <Button size="xs" loading={start.isPending} onClick={() => start.mutate()}>
            Index it again
          </Button>
        )}
      </Group>
      {start.isError && <Failure error={start.error} />}
      {job?.error && <Text size="sm">{`${job.error.message} ${job.error.hint}`}</Text>}
    </Alert>
  );
}
