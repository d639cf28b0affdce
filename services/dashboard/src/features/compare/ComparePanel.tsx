import { Checkbox, Group, Loader, Paper, SegmentedControl, Select, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { volumesQuery } from "@/api/queries";
import type { Artifact, Asset } from "@/api/types";
import { Failure } from "@/app/Notice";
import { significant, volume } from "@/format/format";
import { download } from "@/viewers/download";
import classes from "./compare.module.css";
import { compareLabels } from "./compare";
import { agreement } from "./overlap";

const PARTS = [
  { value: "core", tumor: "Core (1 and 2)", object: "With what it encloses (1 and 2)", values: [1, 2] },
  { value: "enhancing", tumor: "Enhancing (1)", object: "Object (1)", values: [1] },
  { value: "vessels", tumor: "Vessels (3)", object: "Vessels (3)", values: [3] },
] as const;

interface ComparePanelProps {
  labels: Artifact;
  /** What was looked for, which tells what the labels are called. */
  mode: "tumor" | "object";
  reference: Asset | null;
  onReference: (asset: Asset | null) => void;
  /** Values of the reference that count; null: all but 0. */
  values: readonly number[] | null;
  onValues: (values: readonly number[]) => void;
}

/** How well the labels agree with a mask that somebody else has drawn. */
export function ComparePanel({ labels, mode, reference, onReference, values, onValues }: ComparePanelProps) {
  const volumes = useQuery(volumesQuery);
  const masks = (volumes.data?.items ?? []).filter(({ format }) => format === "nifti1");
  return (
    <Paper p="md" component="section" aria-labelledby="compare">
      <Title order={2} id="compare">
        Compare with a mask
      </Title>
      <Text size="sm" c="dimmed" mb="xs">
        With a NIfTI mask that was uploaded; it is drawn over the slices in green, and the surface takes the colors of
        its distance to it.
      </Text>
      <Select
        aria-label="Reference mask"
        placeholder={masks.length === 0 ? "Upload a mask first" : "Choose a mask"}
        data={masks.map(({ id, filename }) => ({ value: id, label: filename }))}
        searchable
        clearable
        value={reference?.id ?? null}
        onChange={(id) => onReference(masks.find((mask) => mask.id === id) ?? null)}
      />
      {reference && (
        <Figures
          key={reference.id}
          labels={labels}
          mode={mode}
          reference={reference}
          chosen={values}
          onChosen={onValues}
        />
      )}
    </Paper>
  );
}

interface FiguresProps {
  labels: Artifact;
  mode: "tumor" | "object";
  reference: Asset;
  chosen: readonly number[] | null;
  onChosen: (values: readonly number[]) => void;
}

function Figures({ labels, mode, reference, chosen, onChosen }: FiguresProps) {
  const compared = useQuery({
    queryKey: ["compare", labels.sha256, reference.sha256],
    staleTime: Number.POSITIVE_INFINITY,
    retry: false,
    queryFn: async ({ signal }) => {
      const nothing = () => undefined;
      const [ours, theirs] = await Promise.all([
        download(labels.url, labels.size, nothing, signal),
        download(reference.content_url, reference.size, nothing, signal),
      ]);
      return compareLabels(ours, theirs, signal);
    },
  });
  const [part, setPart] = useState<(typeof PARTS)[number]["value"]>("core");
  if (compared.isPending) {
    return (
      <Group gap="xs" mt="sm" role="status">
        <Loader size="xs" />
        <Text size="sm" c="dimmed">
          Comparing…
        </Text>
      </Group>
    );
  }
  if (compared.isError) {
    return (
      <div className={classes.figures}>
        <Failure error={compared.error} onRetry={() => void compared.refetch()} />
      </div>
    );
  }
  const { ours, theirs, voxelVolume, resampled } = compared.data;
  const there = theirs.filter((value) => value !== 0);
  const counted = chosen ?? there;
  const parts = PARTS.filter((one) => one.value === "core" || one.values.some((value) => ours.includes(value)));
  const values = PARTS.find(({ value }) => value === part)?.values ?? [];
  const { iou, dice, added, missed } = agreement(compared.data, new Set(values), new Set(counted));
  return (
    <div className={classes.figures}>
      <SegmentedControl
        size="xs"
        aria-label="What is compared"
        data={parts.map((one) => ({ value: one.value, label: one[mode] }))}
        value={part}
        onChange={setPart}
      />
      {there.length > 1 && (
        <Checkbox.Group
          label="Values of the mask that count"
          value={counted.map(String)}
          onChange={(next) => onChosen(next.map(Number))}
        >
          <Group gap="sm" mt={4}>
            {there.map((value) => (
              <Checkbox key={value} size="xs" value={String(value)} label={value} />
            ))}
          </Group>
        </Checkbox.Group>
      )}
      <dl className={classes.measures} data-testid="agreement">
        <div>
          <dt>IoU</dt>
          <dd>{iou.toFixed(3)}</dd>
        </div>
        <div>
          <dt>Dice</dt>
          <dd>{dice.toFixed(3)}</dd>
        </div>
        <div>
          <dt>Missed</dt>
          <dd>{volume(missed * voxelVolume)}</dd>
        </div>
        <div>
          <dt>Added</dt>
          <dd>{volume(added * voxelVolume)}</dd>
        </div>
      </dl>
      <Text size="xs" c="dimmed">
        Computed in this browser, voxel by voxel
        {resampled ? "; the mask lies on another grid, of which the nearest voxel counts" : ""}. A voxel is{" "}
        {significant(voxelVolume, 3)} mm³.
      </Text>
    </div>
  );
}
