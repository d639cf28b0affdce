import { ActionIcon, Slider, Text, Tooltip } from "@mantine/core";
import { Maximize, Palette, Pause, Play } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import { MotionPlayer, type Opened } from "@/features/motion/player";
import { download } from "../download";
import { ViewerFrame, type ViewerStatus } from "../ViewerFrame";
import frame from "../viewers.module.css";
import classes from "./motion.module.css";
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

  const at = useRef(0);
  useEffect(() => {
    at.current = shown;
  }, [shown]);
  useEffect(() => {
    if (!playing || !ready) return;
    const began = performance.now();
    const from = at.current >= count - 1 ? 0 : at.current;
    let before = -1;
    let request = 0;
    const step = (now: number) => {
      const index = Math.floor(from + ((now - began) / 1000) * fps) % count;
      // A frame that is not ready in time is left out rather than shown late.
      if (index !== before && viewer.current && !viewer.current.player.busy) {
        viewer.current.player.want(index);
        before = index;
      }
      request = requestAnimationFrame(step);
    };
    request = requestAnimationFrame(step);
    return () => cancelAnimationFrame(request);
  }, [playing, ready, count, fps]);

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
        <div className={classes.bar}>
          <ActionIcon
            variant="filled"
            size={32}
            radius="xl"
            aria-label={playing ? "Pause" : "Play"}
            disabled={count < 2}
            onClick={() => setPlaying(!playing)}
          >
            {playing ? <Pause size={16} /> : <Play size={16} />}
          </ActionIcon>
          <Slider
            className={classes.slider ?? ""}
            thumbLabel="Frame"
            label={null}
            size="sm"
            min={0}
            max={Math.max(count - 1, 1)}
            disabled={count < 2}
            value={shown}
            onChange={(index) => {
              setPlaying(false);
              viewer.current?.player.want(index);
            }}
          />
          <Text size="xs" c="gray.3" className={classes.place ?? ""} data-testid="frame">
            {shown + 1} / {count}
          </Text>
        </div>
      )}
    </ViewerFrame>
  );
}
