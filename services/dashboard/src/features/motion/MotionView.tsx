import { Paper, Stack, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { lazy, type ReactNode, Suspense, useMemo, useState } from "react";
import { Warnings } from "@/app/Warnings";
import { apiFetch } from "@/api/client";
import type { components } from "@/api/schema";
import type { Job } from "@/api/types";
import { Facts } from "@/app/Facts";
import { calmed, createStore, type Store, useStore } from "@/app/store";
import { Downloads } from "@/features/jobs/Downloads";
import { bytes, integer, significant } from "@/format/format";
import { NoWebGL, ViewerComing } from "@/viewers/ViewerFrame";
import { hasWebGL } from "@/viewers/webgl";
import { Chart } from "./Chart";
import { EncodeAgain } from "./EncodeAgain";
import classes from "./motion.module.css";
import type { MotionResult } from "./result";

type Report = Pick<components["schemas"]["MotionEncodeResult"], "file"> & {
  frame_rmse: number[];
  rate_distortion: { kg_percent: number; motion_bits_per_vertex_frame: number }[];
};

const MotionViewer = lazy(async () => ({
  default: (await import("@/viewers/motion/MotionViewer")).MotionViewer,
}));

/** A compressed motion: played from the file itself, with how far it is from its original. */
export default function MotionView({ job, result, facts }: { job: Job; result: MotionResult; facts: ReactNode }) {
  const [frame] = useState(() => createStore(0));
  const [pointed, setPointed] = useState<number | null>(null);
  const artifact = (name: string) => job.artifacts.find((one) => one.name === name);
  const file = artifact(result.file);
  const reportUrl = artifact("report.json")?.url;
  const report = useQuery({
    queryKey: ["artifact", reportUrl],
    enabled: reportUrl !== undefined,
    staleTime: Number.POSITIVE_INFINITY,
    queryFn: async ({ signal }) => (await (await apiFetch(reportUrl ?? "", { signal })).json()) as Report,
  });
  const curve = (report.data?.rate_distortion ?? [])
    .map((point) => ({ kg: point.kg_percent, bits: point.motion_bits_per_vertex_frame }))
    .filter(({ kg, bits }) => kg > 0 && bits > 0)
    .sort((one, two) => one.kg - two.kg);
  return (
    <Stack gap="md">
      <Warnings of={result.warnings} />
      {!hasWebGL() ? (
        <NoWebGL />
      ) : (
        file && (
          <div className={classes.viewer}>
            <Suspense fallback={<ViewerComing label="Motion" what="Loading the player…" />}>
              <MotionViewer
                url={file.url}
                size={file.size}
                residuals={artifact("residuals.bin.gz") ?? null}
                unit={typeof job.params.unit === "string" ? job.params.unit : ""}
                frame={frame}
              />
            </Suspense>
          </div>
        )
      )}
      <div className={classes.columns}>
        <Stack gap="md">
          {report.data && (
            <Paper p="md" component="section" aria-label="Error and rate">
              <div className={classes.charts}>
                <ErrorByFrame errors={report.data.frame_rmse} frame={frame} />
                <Chart
                  title="Rate and distortion"
                  points={curve.map(({ kg, bits }) => ({ x: Math.log(kg), y: bits }))}
                  xLabel="KG error, %"
                  yLabel="bits per vertex and frame"
                  format={(value) => significant(value, 3)}
                  formatX={(value) => significant(Math.exp(value), 2)}
                  at={pointed === null ? null : Math.log(pointed)}
                  dots
                />
              </div>
            </Paper>
          )}
          <Downloads artifacts={job.artifacts} />
        </Stack>
        <Stack gap="md">
          <Figures result={result} />
          <EncodeAgain
            job={job}
            kg={result.bounds.kg ?? result.errors.kg_percent}
            curve={curve}
            pairs={result.vertices * result.frames}
            onPoint={setPointed}
          />
          {facts}
        </Stack>
      </div>
    </Stack>
  );
}

/** How often a chart follows what plays, in ms: to draw it takes as long as a frame of the motion. */
const FOLLOWS = 100;

function ErrorByFrame({ errors, frame }: { errors: readonly number[]; frame: Store<number> }) {
  const points = useMemo(() => errors.map((y, x) => ({ x, y })), [errors]);
  const calm = useMemo(() => calmed(frame, FOLLOWS), [frame]);
  return (
    <Chart
      title="Error by frame"
      points={points}
      xLabel="frame"
      yLabel="RMS error"
      format={(value) => significant(value, 2)}
      formatX={(value) => integer(value + 1)}
      at={useStore(calm)}
    />
  );
}

function Figures({ result }: { result: MotionResult }) {
  const raw = result.vertices * result.frames * 12 + result.faces * 12;
  const rows: [string, string][] = [
    ["File", bytes(result.bytes)],
    ["Smaller than single precision", `${significant(raw / result.bytes, 3)} times`],
    ["Frames", integer(result.frames)],
    ["Vertices, faces", `${integer(result.vertices)}, ${integer(result.faces)}`],
    ["Clusters", integer(result.clusters)],
    ["Bits per vertex and frame", significant(result.motion_bits_per_vertex_frame, 3)],
    ["Connectivity, bits per vertex", significant(result.connectivity_bits_per_vertex, 3)],
    ["KG error", `${significant(result.errors.kg_percent, 3)} %`],
    ["RMS error, edges", significant(result.errors.rmse_edges, 3)],
    ["Largest error, of the diagonal", `${significant(100 * result.errors.largest_fraction, 3)} %`],
  ];
  return (
    <Paper p="md" component="section" aria-labelledby="figures">
      <Title order={3} mb="xs" id="figures">
        The file
      </Title>
      <Facts rows={rows} />
    </Paper>
  );
}
