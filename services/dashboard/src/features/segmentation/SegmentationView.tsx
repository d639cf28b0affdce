import { Group, Paper, Stack, Text, Title } from "@mantine/core";
import { SearchX } from "lucide-react";
import { lazy, type ReactNode, Suspense, useMemo, useState } from "react";
import { Warnings } from "@/app/Warnings";
import { describe } from "@/api/problem";
import type { Artifact, Asset, Job } from "@/api/types";
import { Empty } from "@/app/Notice";
import { ComparePanel } from "@/features/compare/ComparePanel";
import { distancesTo } from "@/features/compare/distances";
import { Downloads } from "@/features/jobs/Downloads";
import { useDrawable } from "@/features/preview/useDrawable";
import { labelNames, LABELS } from "@/viewers/labels";
import type { Box } from "@/viewers/volume/box";
import { NoWebGL, ViewerComing } from "@/viewers/ViewerFrame";
import { hasWebGL } from "@/viewers/webgl";
import { Alignments } from "./Alignments";
import { BleedingTable } from "./BleedingTable";
import { ObjectTable } from "./ObjectTable";
import type { Point, SegmentationResult } from "./params";
import { SeedPanel } from "./SeedPanel";
import { surfacesOf } from "./surfaces";
import { VesselTable } from "./VesselTable";
import classes from "./segmentation.module.css";

const VolumeViewer = lazy(async () => ({
  default: (await import("@/viewers/volume/VolumeViewer")).VolumeViewer,
}));
const SurfaceViewer = lazy(async () => ({
  default: (await import("@/viewers/surface/SurfaceViewer")).SurfaceViewer,
}));

interface SegmentationViewProps {
  job: Job;
  result: SegmentationResult;
  /** The volume that was segmented; null while it is looked up, or where it was deleted. */
  post: Asset | null;
  facts: ReactNode;
}

export default function SegmentationView({ job, result, post, facts }: SegmentationViewProps) {
  const [chosen, setChosen] = useState<number | null>(null);
  const [seeds, setSeeds] = useState<readonly Point[]>([]);
  const [box, setBox] = useState<Box | null>(null);
  const [looked, setLooked] = useState<Point | null>(null);
  const [reference, setReference] = useState<Asset | null>(null);
  const [values, setValues] = useState<readonly number[] | null>(null);
  const measure = useMemo(
    () =>
      reference && ((points: Float32Array[], signal: AbortSignal) => distancesTo(reference, values, points, signal)),
    [reference, values],
  );
  const mask = useMemo(
    () => reference && { url: reference.content_url, name: "reference.nii.gz", size: reference.size },
    [reference],
  );
  const place = (seed: Point) => setSeeds((before) => (before.length < 64 ? [...before, seed] : before));
  const { objects } = result;
  const names = labelNames(result.mode);
  const present = useMemo(
    () => LABELS.map(({ value }) => value).filter((value) => (result.voxel_counts[String(value)] ?? 0) > 0),
    [result],
  );
  const artifact = (name: string): Artifact | undefined => job.artifacts?.find((one) => one.name === name);
  const labels = artifact("labels.nii.gz");
  const surfaces = useMemo(() => surfacesOf(objects, job.artifacts ?? []), [objects, job.artifacts]);
  const evolution = useMemo(() => {
    const file = job.artifacts?.find(({ name }) => name === "evolution.bin");
    return file ? { url: file.url, size: file.size, color: LABELS[0].color } : null;
  }, [job.artifacts]);
  const focus = useMemo(() => {
    const object = objects.find(({ label }) => label === chosen) ?? objects[0];
    const [x = 0, y = 0, z = 0] = object?.centroid ?? [];
    return object ? ([x, y, z] as const) : null;
  }, [objects, chosen]);
  const volume = useDrawable(post);
  // Until a series is read, the viewer waits; a volume that was deleted or cannot be drawn gives its place to the labels.
  const waits = post !== null && !volume.file && !volume.error;

  return (
    <Stack gap="md">
      <Warnings of={result.warnings} />
      {!hasWebGL() ? (
        <NoWebGL />
      ) : (
        <div className={classes.viewers}>
          {labels && waits && <ViewerComing label="Volume" what="Reading the volume…" />}
          {labels && !waits && (
            <Suspense fallback={<ViewerComing label="Volume" />}>
              <VolumeViewer
                image={volume.file ?? { url: labels.url, name: "labels.nii.gz", size: labels.size }}
                labels={{ url: labels.url, name: "labels.nii.gz", size: labels.size }}
                names={names}
                present={present}
                surfaces={surfaces}
                focus={looked ?? focus}
                reference={mask}
                onSeed={place}
                box={box}
                onBox={setBox}
              />
            </Suspense>
          )}
          {surfaces.length > 0 && (
            <Suspense fallback={<ViewerComing label="Surface" />}>
              <SurfaceViewer
                surfaces={surfaces}
                chosen={surfaces.length > 1 ? chosen : null}
                evolution={evolution}
                measure={measure}
              />
            </Suspense>
          )}
        </div>
      )}
      {post && volume.error !== null && (
        <Text size="sm" c="dimmed">
          Slices of {post.filename} cannot be drawn: {describe(volume.error).message} The labels are shown alone; all
          results can be downloaded.
        </Text>
      )}
      <div className={classes.columns}>
        <Stack gap="md">
          <Paper p="md" component="section" aria-labelledby="objects">
            <Group justify="space-between" mb="xs">
              <Title order={2} id="objects">
                {objects.length === 1 ? "1 object" : `${objects.length} objects`}
              </Title>
              <Group gap="md">
                {LABELS.filter(({ value }) => (result.voxel_counts[String(value)] ?? 0) > 0).map((label) => (
                  <Group key={label.value} gap={6}>
                    <span className={classes.swatch} style={{ background: label.color }} />
                    <Text size="xs" c="dimmed">
                      {names[label.value]}
                    </Text>
                  </Group>
                ))}
              </Group>
            </Group>
            {objects.length === 0 ? (
              <Empty icon={<SearchX size={28} />} title="Nothing was found">
                <Text size="sm" c="dimmed">
                  The method saw no enhancing region. Where you can see one, segment again with a seed point in its rim.
                </Text>
              </Empty>
            ) : (
              <ObjectTable
                objects={objects}
                mode={result.mode}
                chosen={chosen}
                onChoose={(label) => {
                  setLooked(null);
                  setChosen(label);
                }}
              />
            )}
          </Paper>
          <VesselTable result={result} chosen={chosen} onChoose={setChosen} />
          <BleedingTable result={result} onLook={(place) => setLooked(place)} />
          {labels && (
            <ComparePanel
              labels={labels}
              mode={result.mode}
              reference={reference}
              onReference={(asset) => {
                setReference(asset);
                setValues(null);
              }}
              values={values}
              onValues={setValues}
            />
          )}
          {hasWebGL() && (
            <SeedPanel
              job={job}
              seeds={seeds}
              box={box}
              onChange={setSeeds}
              onBox={setBox}
              onLook={(seed) => setLooked([...seed])}
            />
          )}
          <Downloads artifacts={job.artifacts ?? []} />
        </Stack>
        <Stack gap="md">
          <Alignments result={result} />
          {facts}
        </Stack>
      </div>
    </Stack>
  );
}
