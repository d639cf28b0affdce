import { Alert, Button, Group, Paper, Pill, Text, Title } from "@mantine/core";
import { useNavigate } from "@tanstack/react-router";
import { Play } from "lucide-react";
import { useState } from "react";
import { Attempts } from "@/api/idempotency";
import { useCreateJob } from "@/api/queries";
import type { Job } from "@/api/types";
import { anatomical } from "@/format/format";
import { AsCode } from "@/features/snippets/AsCode";
import { jobSnippets } from "@/features/snippets/snippets";

export type Point = [number, number, number];

interface SeedPanelProps {
  job: Job;
  seeds: readonly Point[];
  onChange: (seeds: readonly Point[]) => void;
  /** Look at a seed. */
  onLook: (seed: Point) => void;
}

/** Seeds that were placed in the slices, and the same segmentation once more, started from them. */
export function SeedPanel({ job, seeds, onChange, onLook }: SeedPanelProps) {
  const navigate = useNavigate();
  const create = useCreateJob();
  const [attempts] = useState(() => new Attempts());
  const request = {
    kind: job.kind,
    inputs: job.inputs,
    params: { ...job.params, seeds: seeds.map((seed) => seed.map((value) => Math.round(value * 100) / 100)) },
  };
  return (
    <Paper p="md" component="section" aria-labelledby="seeds">
      <Title order={2} id="seeds">
        Start from points
      </Title>
      {seeds.length === 0 ? (
        <Text size="sm" c="dimmed">
          Click into the rim of what was missed, then “Seed here” above the slices.
        </Text>
      ) : (
        <>
          <Group gap={6} my="sm" component="ul" p={0} style={{ listStyle: "none" }}>
            {seeds.map((seed, index) => (
              <li key={seed.join()}>
                <Pill
                  size="md"
                  withRemoveButton
                  removeButtonProps={{ "aria-label": `Remove seed ${index + 1}`, "aria-hidden": false, tabIndex: 0 }}
                  onRemove={() => onChange(seeds.filter((one) => one !== seed))}
                >
                  <button type="button" style={PLAIN} onClick={() => onLook(seed)}>
                    {anatomical(seed)}
                  </button>
                </Pill>
              </li>
            ))}
          </Group>
          {create.isError && (
            <Alert color="red" variant="light" mb="sm" role="alert">
              {create.error.message}
            </Alert>
          )}
          <Group mb="sm">
            <Button
              size="sm"
              leftSection={<Play size={15} aria-hidden="true" />}
              loading={create.isPending}
              onClick={() =>
                create.mutate(
                  { request, idempotencyKey: attempts.keyFor(request) },
                  { onSuccess: (next) => void navigate({ to: "/jobs/$jobId", params: { jobId: next.id } }) },
                )
              }
            >
              Segment from {seeds.length === 1 ? "this point" : `these ${seeds.length} points`}
            </Button>
          </Group>
          <AsCode of={(target) => jobSnippets(request, target)} />
        </>
      )}
    </Paper>
  );
}

const PLAIN = { all: "unset", cursor: "pointer" } as const;
