import { Maximize } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import { createStore } from "@/app/store";
import { ballOf, spread } from "@/features/motion/reach";
import { download } from "@/viewers/download";
import { MotionCanvas } from "@/viewers/motion/MotionCanvas";
import { StoredControls } from "@/viewers/play/PlayControls";
import { usePlay } from "@/viewers/play/usePlay";
import { Tool } from "@/viewers/Tool";
import { ViewerFrame, type ViewerStatus } from "@/viewers/ViewerFrame";
import frame from "@/viewers/viewers.module.css";
import type { Sequence } from "./sequence";

interface FramesViewerProps {
  url: string;
  size: number;
  kind: "mesh" | "sequence";
  format: string;
}

const FPS = 25;
/** Frames that tell where the mesh goes. */
const SAMPLED = 8;

/** A mesh, or a sequence of meshes that plays, as it was uploaded. */
export default function FramesViewer({ url, size, kind, format }: FramesViewerProps) {
  const parent = useRef<HTMLDivElement>(null);
  const viewer = useRef<{ canvas: MotionCanvas; sequence: Sequence } | null>(null);
  const [status, setStatus] = useState<ViewerStatus>({ is: "loading", fraction: 0, what: "Loading the mesh…" });
  const [attempt, setAttempt] = useState(0);
  const [count, setCount] = useState(1);
  const [playing, setPlaying] = useState(false);
  const [shown] = useState(() => createStore(0));
  const busy = useRef(false);

  useEffect(() => {
    const element = parent.current;
    if (!element) return;
    const controller = new AbortController();
    let canvas: MotionCanvas | null = null;
    const load = async () => {
      const progress = (fraction: number) => setStatus({ is: "loading", fraction, what: "Loading the mesh…" });
      progress(0);
      const content = await download(url, size, progress, controller.signal);
      const sequence = await open(content, kind, format);
      const positions = await sequence.positions(0);
      if (controller.signal.aborted) return;
      canvas = new MotionCanvas(element, positions.length / 3, sequence.faces, () => setStatus({ is: "lost" }));
      canvas.stage.tell("The mesh in 3D.", "mesh");
      const some = await Promise.all(spread(sequence.frames, SAMPLED).map((frame) => sequence.positions(frame)));
      if (controller.signal.aborted) return;
      canvas.expect(some.map(ballOf));
      canvas.show(positions, null);
      viewer.current = { canvas, sequence };
      setCount(sequence.frames);
      setStatus({ is: "ready" });
    };
    load().catch((error: unknown) => {
      if (!controller.signal.aborted) setStatus({ is: "failed", error });
    });
    return () => {
      controller.abort();
      viewer.current = null;
      canvas?.close();
    };
  }, [url, size, kind, format, attempt]);

  const show = (index: number) => {
    const shownBy = viewer.current;
    if (!shownBy || busy.current) return false;
    busy.current = true;
    shownBy.sequence
      .positions(index)
      .then((positions) => {
        if (viewer.current !== shownBy) return;
        shownBy.canvas.show(positions, null);
        shown.set(index);
      })
      .catch((error: unknown) => setStatus({ is: "failed", error }))
      .finally(() => (busy.current = false));
    return true;
  };
  const ready = status.is === "ready";
  usePlay({ playing: playing && ready, count, fps: FPS, shown: shown.get, loop: true, onFrame: show });

  return (
    <ViewerFrame
      label={kind === "mesh" ? "Mesh" : "Sequence"}
      status={status}
      onRetry={() => setAttempt((before) => before + 1)}
      tools={<Tool label="Look at all of it" icon={Maximize} onClick={() => viewer.current?.canvas.look()} />}
    >
      <div ref={parent} className={frame.stage} />
      {ready && count > 1 && (
        <StoredControls count={count} frame={shown} playing={playing} onPlaying={setPlaying} onFrame={show} />
      )}
    </ViewerFrame>
  );
}

async function open(content: ArrayBuffer, kind: "mesh" | "sequence", format: string): Promise<Sequence> {
  if (kind === "sequence") return (await import("./sequence")).openSequence(new Blob([content]));
  const { faces, positions } = (await import("./mesh")).readMesh(content, format);
  return { frames: 1, faces, positions: () => Promise.resolve(positions) };
}
