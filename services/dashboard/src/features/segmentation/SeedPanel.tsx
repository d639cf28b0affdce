import { Button, Group, NumberInput, Paper, Pill, Text, Title } from "@mantine/core";
import { useNavigate } from "@tanstack/react-router";
import { Play, X } from "lucide-react";
import { useState } from "react";
import { Attempts } from "@/api/idempotency";
import { useCreateJob } from "@/api/queries";
import type { Job } from "@/api/types";
import { Failure } from "@/app/Notice";
import { AsCode } from "@/features/snippets/AsCode";
import { jobSnippets } from "@/features/snippets/snippets";
import { anatomical } from "@/format/format";
import type { Box } from "@/viewers/volume/box";
import { onceMore, type Point } from "./params";
import classes from "./segmentation.module.css";

interface SeedPanelProps {
  job: Job;
  seeds: readonly Point[];
  box: Box | null;
  onChange: (seeds: readonly Point[]) => void;
  onBox: (box: Box | null) => void;
  /** Look at a seed. */
  onLook: (seed: Point) => void;
}

/** Seeds and a box that were drawn in the slices, and the same segmentation once more, started from them. */
export function SeedPanel({ job, seeds, box, onChange, onBox, onLook }: SeedPanelProps) {
  const navigate = useNavigate();
  const create = useCreateJob();
  const [attempts] = useState(() => new Attempts());
  const request = onceMore(job, seeds, box);
  const points = seeds.length === 1 ? "this point" : `these ${seeds.length} points`;
  return (
    <Paper p="md" component="section" aria-labelledby="seeds">
      <Title order={2} id="seeds">
        Start from points or a box
      </Title>
      {seeds.length === 0 && box === null ? (
        <Text size="sm" c="dimmed">
          Click into the rim of what was missed, then “Seed here” above the slices. Or draw a box around any object:
          what is in it is segmented, whatever it is.
        </Text>
      ) : (
        <>
          {seeds.length > 0 && (
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
          )}
          {box && <BoxFields box={box} onBox={onBox} />}
          {create.isError && <Failure error={create.error} />}
          <Group my="sm">
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
              Segment {box ? "what is in the box" : `from ${points}`}
            </Button>
          </Group>
          <AsCode of={(target) => jobSnippets(request, target)} />
        </>
      )}
    </Paper>
  );
}

const PLAIN = { all: "unset", cursor: "pointer" } as const;
const SIDES = ["Left", "Back", "Bottom", "Right", "Front", "Top"] as const;

/** The sides of the box as numbers, for those who know them or draw with no mouse. */
function BoxFields({ box, onBox }: { box: Box; onBox: (box: Box | null) => void }) {
  return (
    <div className={classes.box} role="group" aria-label="Sides of the box, RAS mm">
      {SIDES.map((label, k) => (
        <NumberInput
          key={label}
          size="xs"
          label={label}
          suffix=" mm"
          decimalScale={1}
          step={1}
          value={Math.round(10 * (box[k] as number)) / 10}
          onChange={(value) => {
            if (typeof value !== "number" || value === box[k]) return;
            const next = [...box] as [number, number, number, number, number, number];
            next[k] = value;
            onBox(next);
          }}
        />
      ))}
      <Button
        size="xs"
        variant="default"
        leftSection={<X size={13} aria-hidden="true" />}
        className={classes.noBox ?? ""}
        onClick={() => onBox(null)}
      >
        No box
      </Button>
    </div>
  );
}
