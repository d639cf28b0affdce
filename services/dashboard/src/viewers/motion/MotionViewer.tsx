import { ActionIcon, Tooltip } from "@mantine/core";
import { Maximize, Palette } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import { MotionPlayer, type Opened } from "@/features/motion/player";
import { download } from "../download";
import { PlayControls } from "../play/PlayControls";
import { usePlay } from "../play/usePlay";
import { ViewerFrame, type ViewerStatus } from "../ViewerFrame";
import frame from "../viewers.module.css";
import { MotionCanvas } from "./MotionCanvas";

interface MotionViewerProps {
  url: string;
  size: number;
  /** Told of each frame as it is shown. */
  onFrame: (index: number) => void;
}

const USUAL_FPS = 25;

/** A compressed motion, decoded in the browser while it plays. */
export function MotionViewer({ url, size, onFrame }: MotionViewerProps) {
  const parent = useRef<HTMLDivElement>(null);
  const viewer = useRef<{ canvas: MotionCanvas; player: MotionPlayer; opened: Opened } | null>(null);
  const [status, setStatus] = useState<ViewerStatus>({ is: "loading", fraction: 0, what: "Loading the motion…" });
  const [attempt, setAttempt] = useState(0);
  const [opened, setOpened] = useState<Opened | null>(null);
  const [shown, setShown] = useState(0);
  const [playing, setPlaying] = useState(false);
  const [clusters, setClusters] = useState(false);
  const tell = useRef(onFrame);
  useEffect(() => {
    tell.current = onFrame;
  }, [onFrame]);

  useEffect(() => {
    const element = parent.current;
    if (!element) return;
    const controller = new AbortController();
    let canvas: MotionCanvas | null = null;
    const fail = (error: unknown) => {
      if (!controller.signal.aborted) setStatus({ is: "failed", error });
    };
    const player = new MotionPlayer((index, positions) => {
      canvas?.show(positions);
      setShown(index);
      tell.current(index);
    });
    const load = async () => {
      const progress = (fraction: number) => setStatus({ is: "loading", fraction, what: "Loading the motion…" });
      progress(0);
      const content = await download(url, size, progress, controller.signal);
      setStatus({ is: "loading", fraction: 1, what: "Decoding…" });
      const motion = await player.open(content, fail);
      if (controller.signal.aborted) return;
      canvas = new MotionCanvas(element, motion.header.vertices, motion.faces);
      canvas.canvas.dataset.testid = "motion";
      canvas.canvas.setAttribute("aria-label", "The motion in 3D. Drag to turn it.");
      canvas.canvas.addEventListener("webglcontextlost", (event) => {
        event.preventDefault();
        if (!controller.signal.aborted) setStatus({ is: "lost" });
      });
      viewer.current = { canvas, player, opened: motion };
      player.want(0);
      setOpened(motion);
      setStatus({ is: "ready" });
    };
    load().catch(fail);
    return () => {
      controller.abort();
      viewer.current = null;
      player.close();
      canvas?.close();
    };
  }, [url, size, attempt]);

  const ready = status.is === "ready";
  const count = opened?.header.frames ?? 1;
  const fps = opened?.header.fps ? opened.header.fps : USUAL_FPS;
  useEffect(() => {
    if (ready && viewer.current) viewer.current.canvas.color(clusters ? viewer.current.opened.labels : null);
  }, [ready, clusters]);

  usePlay({
    playing: playing && ready,
    count,
    fps,
    shown,
    loop: true,
    onFrame: (index) => {
      const player = viewer.current?.player;
      if (!player || player.busy) return false;
      player.want(index);
      return true;
    },
  });

  return (
    <ViewerFrame
      label="Motion"
      status={status}
      onRetry={() => setAttempt((before) => before + 1)}
      tools={
        <>
          <Tooltip label="Color by cluster" openDelay={400}>
            <ActionIcon
              variant={clusters ? "filled" : "default"}
              size={30}
              aria-label="Color by cluster"
              aria-pressed={clusters}
              onClick={() => setClusters(!clusters)}
            >
              <Palette size={16} />
            </ActionIcon>
          </Tooltip>
          <Tooltip label="Look at all of it" openDelay={400}>
            <ActionIcon
              variant="default"
              size={30}
              aria-label="Look at all of it"
              onClick={() => viewer.current?.canvas.look()}
            >
              <Maximize size={16} />
            </ActionIcon>
          </Tooltip>
        </>
      }
    >
      <div ref={parent} className={frame.stage} />
      {ready && (
        <PlayControls
          count={count}
          shown={shown}
          playing={playing}
          onPlaying={setPlaying}
          onFrame={(index) => viewer.current?.player.want(index)}
        />
      )}
    </ViewerFrame>
  );
}
