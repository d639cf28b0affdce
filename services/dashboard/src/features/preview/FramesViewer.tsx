import { Maximize } from "lucide-react";
import { useRef, useState } from "react";
import { createStore } from "@/app/store";
import { integer } from "@/format/format";
import { download } from "@/viewers/download";
import { MotionCanvas } from "@/viewers/motion/MotionCanvas";
import { StoredControls } from "@/viewers/play/PlayControls";
import { usePlay } from "@/viewers/play/usePlay";
import { Tool } from "@/viewers/Tool";
import { useDrawing } from "@/viewers/useDrawing";
import { ViewerFrame } from "@/viewers/ViewerFrame";
import frame from "@/viewers/viewers.module.css";
import { Frames } from "./frames";
import classes from "./preview.module.css";

interface FramesViewerProps {
  url: string;
  size: number;
  kind: "mesh" | "sequence";
  format: string;
}

const FPS = 25;
/** Faces that are drawn at the most: so many move smoothly, and are there soon. */
const MOST = 200_000;

/** A mesh, or a sequence of meshes that plays, as it was uploaded, but for faces that are too many to be drawn. */
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
      const file = keep(new Frames());
      tell("Reading the mesh…", 1);
      const { frames, faces, positions, whole, reach } = await file.open({ content, kind, format, most: MOST });
      signal.throwIfAborted();
      if (frames === 1) file.close(); // with all that it holds
      const canvas = keep(new MotionCanvas(element, positions.length / 3, faces, onLost));
      canvas.stage.tell("The mesh in 3D.", "mesh");
      canvas.expect(reach);
      canvas.show(positions, null);
      return { canvas, file, frames, drawn: faces.length / 3, whole, signal, fail };
    },
  );

  const show = (index: number) => {
    if (!drawing || busy.current) return false;
    const { canvas, file, signal, fail } = drawing;
    busy.current = true;
    file
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
  const count = drawing?.frames ?? 1;
  usePlay({ playing: playing && drawing !== null, count, fps: FPS, shown: shown.get, loop: true, onFrame: show });

  return (
    <ViewerFrame
      label={kind === "mesh" ? "Mesh" : "Sequence"}
      status={status}
      onRetry={retry}
      tools={<Tool label="Look at all of it" icon={Maximize} onClick={() => drawing?.canvas.look()} />}
    >
      <div ref={parent} className={frame.stage} />
      {drawing && drawing.drawn < drawing.whole && (
        <div className={count > 1 ? `${frame.readout} ${classes.above}` : frame.readout}>
          {`drawn coarser than it is: ${integer(drawing.drawn)} of ${integer(drawing.whole)} faces`}
        </div>
      )}
      {count > 1 && (
        <StoredControls count={count} frame={shown} playing={playing} onPlaying={setPlaying} onFrame={show} />
      )}
    </ViewerFrame>
  );
}
