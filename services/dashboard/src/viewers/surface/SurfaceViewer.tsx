import { Clapperboard, Grid3x3, Maximize, Ruler } from "lucide-react";
import { useEffect, useEffectEvent, useState } from "react";
import { sayFailure } from "@/app/say";
import { download } from "../download";
import { PlayControls } from "../play/PlayControls";
import { usePlay } from "../play/usePlay";
import { Tool } from "../Tool";
import { useDrawing } from "../useDrawing";
import { ViewerFrame } from "../ViewerFrame";
import frame from "../viewers.module.css";
import { type Frame, readEvolution, sceneAt } from "./evolution";
import { DistanceLegend } from "./DistanceLegend";
import { LayerMenu, type Opacities } from "./LayerMenu";
import { distanceColors, type Spread, spreadOf } from "./scale";
import { SurfaceCanvas } from "./SurfaceCanvas";
import type { SurfaceFile } from "./surfaceFile";

interface SurfaceViewerProps {
  surfaces: readonly SurfaceFile[];
  chosen: number | null;
  /** How the surfaces came to be. */
  evolution?: { url: string; size: number; color: string } | null;
  /** Measures how far points (RAS mm) of the objects lie from a reference, negative inside; they are colored by it. */
  measure?: ((points: Float32Array[], signal: AbortSignal) => Promise<Float32Array[]>) | null;
}

/** Of a replay: an object has 25 frames at the most. */
const FPS = 10;

/**
 * The recovered surfaces in space. Drawn with three rather than niivue: a lit mesh one turns and inspects down to its
 * edges, one color and opacity to each object, and the same code for the meshes of shapes and motions.
 */
export function SurfaceViewer({ surfaces, chosen, evolution = null, measure = null }: SurfaceViewerProps) {
  const [edges, setEdges] = useState(false);
  const [opacities, setOpacities] = useState<Opacities>({});
  const [replaying, setReplaying] = useState(false);
  const [frames, setFrames] = useState<readonly Frame[]>([]);
  const [shown, setShown] = useState(0);
  const [playing, setPlaying] = useState(false);
  const [distances, setDistances] = useState(true);
  const [spread, setSpread] = useState<Spread | null>(null);
  const what = "Loading the surface…";
  const key = surfaces.map(({ url }) => url).join(" ");
  const {
    parent,
    status,
    drawing: canvas,
    retry,
  } = useDrawing(key, what, async ({ element, signal, tell, onLost, keep }) => {
    const canvas = keep(new SurfaceCanvas(element, onLost));
    canvas.stage.tell("The surface in 3D.", "surface");
    const total = surfaces.reduce((sum, { size }) => sum + size, 0) || 1;
    let before = 0;
    for (const { id, url, size, color } of surfaces) {
      const progress = (fraction: number) => tell(what, (before + fraction * size) / total);
      const content = await download(url, size, progress, signal);
      signal.throwIfAborted();
      canvas.add({ id, content, color });
      before += size;
    }
    canvas.look();
    return canvas;
  });

  useEffect(() => {
    canvas?.drawEdges(edges);
  }, [canvas, edges]);
  useEffect(() => {
    if (!canvas) return;
    canvas.choose(chosen);
    if (chosen !== null) canvas.look(chosen);
  }, [canvas, chosen]);

  const groupOf = useEffectEvent(() => surfaces.map(({ id, group }) => [id, group] as const));
  useEffect(() => {
    if (!canvas) return;
    for (const [id, group] of groupOf()) canvas.fade(id, opacities[group] ?? 1);
  }, [canvas, opacities]);

  useEffect(() => {
    if (!replaying || frames.length > 0 || !evolution) return;
    const controller = new AbortController();
    download(evolution.url, evolution.size, () => undefined, controller.signal)
      .then((content) => {
        setFrames(readEvolution(content));
        setShown(0);
        setPlaying(true);
      })
      .catch((error: unknown) => {
        if (controller.signal.aborted) return;
        setReplaying(false);
        sayFailure("How it grew cannot be shown", error);
      });
    return () => controller.abort();
  }, [replaying, frames, evolution]);
  const measured = useEffectEvent(() => surfaces.filter(({ label }) => label === 1).map(({ id }) => id));
  useEffect(() => {
    if (!canvas || !distances || !measure) return;
    const controller = new AbortController();
    const ids = measured();
    measure(
      ids.map((id) => canvas.positions(id)),
      controller.signal,
    )
      .then((found) => {
        if (controller.signal.aborted) return;
        const told = spreadOf(found);
        found.forEach((some, index) => canvas.tint(ids[index] ?? -1, distanceColors(some, told.end)));
        setSpread(told);
      })
      .catch((error: unknown) => {
        if (!controller.signal.aborted) sayFailure("The distances cannot be measured", error);
      });
    return () => {
      controller.abort();
      for (const id of ids) canvas.tint(id, null);
      setSpread(null);
    };
  }, [canvas, distances, measure]);
  const on = canvas !== null && replaying && frames.length > 0;
  const color = evolution?.color ?? "";
  useEffect(() => {
    // What grew is looked at as it is in the end; afterwards at everything again.
    if (!on) return;
    canvas.grow(sceneAt(frames, frames.length - 1), color);
    canvas.look();
    return () => {
      canvas.grow(null, color);
      canvas.look();
    };
  }, [on, canvas, frames, color]);
  useEffect(() => {
    if (on) canvas.grow(sceneAt(frames, shown), color);
  }, [on, canvas, frames, shown, color]);
  usePlay({
    playing: playing && on,
    count: frames.length,
    fps: FPS,
    shown: () => shown,
    loop: false,
    onFrame: (index) => {
      setShown(index);
      return true;
    },
    onEnd: () => setPlaying(false),
  });

  return (
    <ViewerFrame
      label="Surface"
      status={status}
      onRetry={retry}
      tools={
        <>
          {evolution && (
            <Tool
              label="Watch how it grew"
              icon={Clapperboard}
              on={replaying}
              onClick={() => {
                setReplaying(!replaying);
                setShown(0);
                setPlaying(!replaying);
              }}
            />
          )}
          {measure && (
            <Tool
              label="Color by the distance to the mask"
              icon={Ruler}
              on={distances}
              onClick={() => setDistances(!distances)}
            />
          )}
          <LayerMenu surfaces={surfaces} opacities={opacities} onChange={setOpacities} />
          <Tool label="Show the mesh's edges" icon={Grid3x3} on={edges} onClick={() => setEdges(!edges)} />
          <Tool label="Look at all of it" icon={Maximize} onClick={() => canvas?.look()} />
        </>
      }
    >
      <div ref={parent} className={frame.stage} />
      {spread && !on && <DistanceLegend spread={spread} />}
      {on && (
        <PlayControls count={frames.length} shown={shown} playing={playing} onPlaying={setPlaying} onFrame={setShown} />
      )}
    </ViewerFrame>
  );
}
