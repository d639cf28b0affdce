import { SegmentedControl, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { Maximize } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import type { Artifact } from "@/api/types";
import type { Store } from "@/app/store";
import { MotionPlayer } from "@/features/motion/player";
import { readResiduals, type Residuals, typicalError } from "@/features/motion/residuals";
import { significant } from "@/format/format";
import { download } from "../download";
import { StoredControls } from "../play/PlayControls";
import { usePlay } from "../play/usePlay";
import { SaveMesh } from "../SaveMesh";
import { Tool } from "../Tool";
import { useDrawing } from "../useDrawing";
import { ViewerFrame } from "../ViewerFrame";
import frame from "../viewers.module.css";
import classes from "./motion.module.css";
import { ERROR_GRADIENT } from "./errorColors";
import { type Coloring, type Difference, type Layout, MotionCanvas } from "./MotionCanvas";

interface MotionViewerProps {
  url: string;
  size: number;
  /** The file that leads back to the original, if there is one. */
  residuals: Artifact | null;
  /** The unit of the coordinates, as far as known. */
  unit: string;
  /** The frame that is shown, told to whoever wants to know. */
  frame: Store<number>;
}

const USUAL_FPS = 25;
/** The last color stands for so many typical errors; few vertices are farther off. */
const MOST = 4;
const LAYOUTS: { value: Layout; label: string }[] = [
  { value: "decoded", label: "Decoded" },
  { value: "original", label: "Original" },
  { value: "beside", label: "Side by side" },
  { value: "overlaid", label: "Overlaid" },
];
const COLORINGS: { value: Coloring; label: string }[] = [
  { value: "plain", label: "Plain" },
  { value: "clusters", label: "Clusters" },
  { value: "error", label: "Error" },
];

function differenceOf(residuals: Residuals | null, typical: number, index: number): Difference | null {
  if (!residuals) return null;
  const { vertices, values, step } = residuals;
  return { residuals: values.subarray(3 * vertices * index, 3 * vertices * (index + 1)), step, most: MOST * typical };
}

/** A compressed motion, decoded in the browser while it plays. */
export function MotionViewer({ url, size, residuals, unit, frame: shown }: MotionViewerProps) {
  const [playing, setPlaying] = useState(false);
  const [layout, setLayout] = useState<Layout>("decoded");
  const [coloring, setColoring] = useState<Coloring>("plain");
  const needed = layout !== "decoded" || coloring === "error";
  const before = useQuery({
    queryKey: ["residuals", residuals?.sha256],
    enabled: residuals !== null && needed,
    staleTime: Number.POSITIVE_INFINITY,
    gcTime: 0,
    retry: false,
    queryFn: async ({ signal }) => {
      const content = await download(residuals?.url ?? "", residuals?.size ?? 0, () => undefined, signal);
      const found = await readResiduals(content);
      return { residuals: found, typical: typicalError(found) };
    },
  });
  const differs = useRef<{ residuals: Residuals; typical: number } | null>(null);

  const what = "Loading the motion…";
  const { parent, status, drawing, retry } = useDrawing(
    url,
    what,
    async ({ element, signal, tell, fail, onLost, keep }) => {
      let canvas: MotionCanvas | null = null;
      const onFrame = (index: number, positions: Float32Array) => {
        const { residuals = null, typical = 0 } = differs.current ?? {};
        canvas?.show(positions, differenceOf(residuals, typical, index));
        shown.set(index);
      };
      const player = keep(new MotionPlayer(onFrame));
      const content = await download(url, size, (fraction) => tell(what, fraction), signal);
      tell("Decoding…", 1);
      const opened = await player.open(content, fail);
      signal.throwIfAborted();
      canvas = keep(new MotionCanvas(element, opened.header.vertices, opened.faces, onLost));
      canvas.stage.tell("The motion in 3D.", "motion");
      canvas.expect(opened.reach);
      player.want(0);
      return { canvas, player, opened };
    },
  );

  const opened = drawing?.opened ?? null;
  const count = opened?.header.frames ?? 1;
  const fps = opened?.header.fps ? opened.header.fps : USUAL_FPS;
  // What needs the original is shown as soon as that is here.
  const known = before.data ?? null;
  const waits = needed && !known;
  useEffect(() => {
    differs.current = known;
    if (!drawing) return;
    drawing.canvas.arrange(
      waits ? "decoded" : layout,
      waits && coloring === "error" ? "plain" : coloring,
      drawing.opened.labels,
    );
    drawing.player.want(shown.get());
  }, [drawing, layout, coloring, known, waits, shown]);
  const beside = layout === "beside";
  useEffect(() => {
    drawing?.canvas.look();
  }, [drawing, beside]);

  usePlay({
    playing: playing && drawing !== null,
    count,
    fps,
    shown: shown.get,
    loop: true,
    onFrame: (index) => {
      if (!drawing || drawing.player.busy) return false;
      drawing.player.want(index);
      return true;
    },
  });

  const frameShown = () => {
    const mesh = drawing?.canvas.mesh();
    return mesh ? Promise.resolve(mesh) : Promise.reject(new Error("No frame is shown."));
  };

  return (
    <ViewerFrame
      label="Motion"
      status={status}
      onRetry={retry}
      tools={
        <>
          {residuals && (
            <SegmentedControl
              size="xs"
              aria-label="What is shown"
              data={LAYOUTS}
              value={layout}
              onChange={(value) => setLayout(value)}
            />
          )}
          <SegmentedControl
            size="xs"
            aria-label="Color"
            data={residuals ? COLORINGS : COLORINGS.filter(({ value }) => value !== "error")}
            value={coloring}
            onChange={(value) => setColoring(value)}
          />
          <SaveMesh name="frame" mesh={frameShown} tool="Save this frame as a mesh" />
          <Tool label="Look at all of it" icon={Maximize} onClick={() => drawing?.canvas.look()} />
        </>
      }
    >
      <div ref={parent} className={frame.stage} />
      {drawing && needed && !known && (
        <Text className={classes.note ?? ""} size="xs" role={before.isError ? "alert" : "status"}>
          {before.isError ? "The original could not be loaded." : "Loading the original…"}
        </Text>
      )}
      {drawing && !waits && beside && (
        <div className={classes.sides} aria-hidden="true">
          <span>Original</span>
          <span>Decoded</span>
        </div>
      )}
      {drawing && !waits && layout === "overlaid" && (
        <div className={classes.key}>
          <i className={classes.wire} /> original, as lines
        </div>
      )}
      {drawing && known && coloring === "error" && (
        <figure className={classes.legend} aria-label="Error by color">
          <figcaption>Distance from the original{unit && `, ${unit}`}</figcaption>
          <div className={classes.ramp} style={{ background: ERROR_GRADIENT }} />
          <div className={classes.ends}>
            <span>0</span>
            <span>RMS {significant(known.typical, 2)}</span>
            <span>≥ {significant(MOST * known.typical, 2)}</span>
          </div>
        </figure>
      )}
      {drawing && (
        <StoredControls
          count={count}
          frame={shown}
          playing={playing}
          onPlaying={setPlaying}
          onFrame={(index) => drawing?.player.want(index)}
        />
      )}
    </ViewerFrame>
  );
}
