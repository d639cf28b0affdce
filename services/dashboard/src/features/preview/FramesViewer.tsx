import { Maximize } from "lucide-react";
import { useRef, useState } from "react";
import { createStore } from "@/app/store";
import { ballOf, spread } from "@/features/motion/reach";
import { download } from "@/viewers/download";
import { MotionCanvas } from "@/viewers/motion/MotionCanvas";
import { StoredControls } from "@/viewers/play/PlayControls";
import { usePlay } from "@/viewers/play/usePlay";
import { Tool } from "@/viewers/Tool";
import { useDrawing } from "@/viewers/useDrawing";
import { ViewerFrame } from "@/viewers/ViewerFrame";
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
  const [playing, setPlaying] = useState(false);
  const [shown] = useState(() => createStore(0));
  const busy = useRef(false);

  const what = "Loading the mesh…";
  const { parent, status, drawing, retry } = useDrawing(
    `${url} ${kind} ${format}`,
    what,
    async ({ element, signal, tell, fail, onLost, keep }) => {
      const content = await download(url, size, (fraction) => tell(what, fraction), signal);
      const sequence = await open(content, kind, format);
      const positions = await sequence.positions(0);
      signal.throwIfAborted();
      const canvas = keep(new MotionCanvas(element, positions.length / 3, sequence.faces, onLost));
      canvas.stage.tell("The mesh in 3D.", "mesh");
      const some = await Promise.all(spread(sequence.frames, SAMPLED).map((frame) => sequence.positions(frame)));
      signal.throwIfAborted();
      canvas.expect(some.map(ballOf));
      canvas.show(positions, null);
      return { canvas, sequence, signal, fail };
    },
  );

  const show = (index: number) => {
    if (!drawing || busy.current) return false;
    const { canvas, sequence, signal, fail } = drawing;
    busy.current = true;
    sequence
      .positions(index)
      .then((positions) => {
        if (signal.aborted) return;
        canvas.show(positions, null);
        shown.set(index);
      })
      .catch(fail)
      .finally(() => (busy.current = false));
    return true;
  };
  const count = drawing?.sequence.frames ?? 1;
  usePlay({ playing: playing && drawing !== null, count, fps: FPS, shown: shown.get, loop: true, onFrame: show });

  return (
    <ViewerFrame
      label={kind === "mesh" ? "Mesh" : "Sequence"}
      status={status}
      onRetry={retry}
      tools={<Tool label="Look at all of it" icon={Maximize} onClick={() => drawing?.canvas.look()} />}
    >
      <div ref={parent} className={frame.stage} />
      {count > 1 && (
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
