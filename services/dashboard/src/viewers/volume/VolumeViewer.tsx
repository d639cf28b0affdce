import { Button, SegmentedControl, Tooltip } from "@mantine/core";
import { LocateFixed, SquareDashed } from "lucide-react";
import { useEffect, useEffectEvent, useState } from "react";
import { sayFailure } from "@/app/say";
import { anatomical, significant } from "@/format/format";
import { download } from "../download";
import { type LabelNames, labelNames } from "../labels";
import { readSurface } from "../surface/readSurface";
import type { SurfaceFile } from "../surface/surfaceFile";
import { Tool } from "../Tool";
import { useDrawing } from "../useDrawing";
import { ViewerFrame } from "../ViewerFrame";
import frame from "../viewers.module.css";
import { around, type Box } from "./box";
import { BoxLayer } from "./BoxLayer";
import { DisplayMenu } from "./DisplayMenu";
import { loadVolume, type VolumeFile } from "./loadVolume";
import { type Display, mostVoxels, type Place, VolumeCanvas, type VolumeLayout } from "./VolumeCanvas";

interface VolumeViewerProps {
  image: VolumeFile;
  labels: VolumeFile | null;
  /** What the labels are called, and which of them occur. */
  names?: LabelNames;
  present?: readonly number[];
  /** Drawn in 3D in the place of the labels that they bound. */
  surfaces?: readonly SurfaceFile[];
  /** Where to look, RAS mm; a new array moves the crosshair. */
  focus: readonly [number, number, number] | null;
  /** A mask to lay over the labels. */
  reference?: VolumeFile | null;
  /** Someone wants a seed where the crosshair is, RAS mm. */
  onSeed?: ((mm: [number, number, number]) => void) | undefined;
  /** A box to show and to draw over the slices. */
  box?: Box | null;
  onBox?: ((box: Box) => void) | undefined;
}

/** How long the sides of a box are before somebody draws it, in mm, where the volume is not smaller. */
const FIRST_BOX = 40;

/** Its clusters are small and many: they are drawn from the voxels. */
const BLEEDING = 4;
const LAYOUTS: { value: VolumeLayout; label: string }[] = [
  { value: "slices", label: "Slices" },
  { value: "axial", label: "Axial" },
  { value: "coronal", label: "Coronal" },
  { value: "sagittal", label: "Sagittal" },
  { value: "render", label: "3D" },
];

const NAMES = labelNames();
const NONE: readonly number[] = [];
const NO_SURFACES: readonly SurfaceFile[] = [];

/** A volume in slices or as a whole, with labels over it. */
export function VolumeViewer({
  image,
  labels,
  names = NAMES,
  present = NONE,
  surfaces = NO_SURFACES,
  focus,
  reference = null,
  onSeed,
  box = null,
  onBox,
}: VolumeViewerProps) {
  const [draws, setDraws] = useState(false);
  const [place, setPlace] = useState<Place | null>(null);
  const [range, setRange] = useState<[number, number]>([0, 1]);
  const [coarse, setCoarse] = useState(false);
  const [display, setDisplay] = useState<Display>({
    layout: "slices",
    opacity: 0.55,
    layers: {},
    volumeOpacity: 0.35,
    outline: false,
    referenceOpacity: 0.45,
    radiological: true,
    window: [0, 1],
  });
  const change = (part: Partial<Display>) => setDisplay((before) => ({ ...before, ...part }));

  const what = "Loading the volume…";
  const {
    parent,
    status,
    drawing: canvas,
    retry,
  } = useDrawing(`${image.url} ${labels?.url}`, what, async ({ element, signal, tell, onLost, keep }) => {
    const making = () =>
      new Promise<VolumeCanvas>((resolve) => {
        const canvas = keep(new VolumeCanvas(element, setPlace, onLost));
        canvas.canvas.dataset.testid = "volume";
        resolve(canvas);
      });
    const load = async (file: VolumeFile, isLabels: boolean, onProgress: (fraction: number) => void) => ({
      name: file.name,
      ...(await loadVolume(file, mostVoxels(), isLabels, onProgress, signal)),
    });
    const [source, overlay, canvas] = await Promise.all([
      load(image, false, (fraction) => tell(what, fraction)),
      labels && load(labels, true, () => undefined),
      making(), // the page stands still for it; the files are on their way meanwhile
    ]);
    tell("Drawing…", 1);
    const { range: whole, window, coarse: isCoarse } = await canvas.open(source, overlay, display);
    signal.throwIfAborted();
    setRange(whole);
    setCoarse(isCoarse);
    change({ window });
    return canvas;
  });

  const opacity = useEffectEvent(() => display.referenceOpacity);
  useEffect(() => {
    if (!canvas) return;
    const controller = new AbortController();
    const lay = async () => {
      const mask = reference
        ? await loadVolume(reference, mostVoxels(), true, () => undefined, controller.signal)
        : null;
      await canvas.lay(reference && mask ? { name: reference.name, ...mask } : null, opacity());
    };
    lay().catch((error: unknown) => {
      if (!controller.signal.aborted) sayFailure("The reference cannot be drawn", error);
    });
    return () => controller.abort();
  }, [canvas, reference]);
  useEffect(() => {
    canvas?.show(display);
  }, [canvas, display]);
  const solid = display.layout === "render";
  const bounded = surfaces.filter(({ label }) => label !== BLEEDING);
  const wanted = useEffectEvent(() => bounded);
  const urls = bounded.map(({ url }) => url).join(" ");
  useEffect(() => {
    if (!canvas || !solid) return;
    const controller = new AbortController();
    const load = async () => {
      const missing = wanted().filter(({ url }) => !canvas.has(url));
      const found = missing.map(async ({ url, size, label }) => {
        const content = await download(url, size, () => undefined, controller.signal);
        return { name: url, label, surface: readSurface(content) };
      });
      const surfaces = await Promise.all(found);
      if (!controller.signal.aborted && surfaces.length > 0) canvas.addSurfaces(surfaces);
    };
    load().catch((error: unknown) => {
      if (!controller.signal.aborted) sayFailure("The surfaces cannot be drawn", error);
    });
    return () => controller.abort();
  }, [canvas, solid, urls]);
  useEffect(() => {
    if (focus) canvas?.goTo(focus);
  }, [canvas, focus]);
  useEffect(() => {
    canvas?.canvas.setAttribute(
      "aria-label",
      `${display.layout === "render" ? "The volume in 3D" : `Slices, ${display.layout}`}. ` +
        "Arrow keys and page up and down move the crosshair.",
    );
  }, [canvas, display.layout]);

  const drawBox = () => {
    setDraws(!draws);
    if (draws) return;
    if (solid) change({ layout: "slices" });
    const extent = (canvas?.views() ?? []).flatMap(({ size }) => size);
    if (!box && place) onBox?.(around(place.mm, Math.min(FIRST_BOX, ...extent.map((length) => length / 4))));
  };

  return (
    <ViewerFrame
      label="Volume"
      status={status}
      onRetry={retry}
      tools={
        <>
          {onSeed && place && (
            <Tooltip label="Put a seed where the crosshair is" openDelay={400}>
              <Button
                size="compact-sm"
                variant="default"
                leftSection={<LocateFixed size={15} aria-hidden="true" />}
                onClick={() => onSeed(place.mm)}
              >
                Seed here
              </Button>
            </Tooltip>
          )}
          {onBox && <Tool label="Draw a box" icon={SquareDashed} on={draws && !solid} onClick={drawBox} />}
          <SegmentedControl
            size="xs"
            aria-label="View"
            data={LAYOUTS}
            value={display.layout}
            onChange={(value) => change({ layout: value })}
          />
          <DisplayMenu
            display={display}
            range={range}
            hasLabels={labels !== null}
            present={present}
            names={names}
            hasReference={reference !== null}
            onChange={change}
          />
        </>
      }
    >
      <div ref={parent} className={frame.stage} />
      {canvas && box && place && !solid && (
        <BoxLayer
          canvas={canvas}
          box={box}
          at={place.mm}
          draws={draws && onBox !== undefined}
          onChange={(next) => onBox?.(next)}
        />
      )}
      {place && canvas && (
        <div className={frame.readout} data-testid="place">
          {anatomical(place.mm)}
          {place.intensity === null ? "" : `   ${significant(place.intensity, 4)}`}
          {place.label > 0 ? `   ${names[place.label] ?? `label ${place.label}`}` : ""}
          {coarse ? "   drawn coarser than it is" : ""}
        </div>
      )}
    </ViewerFrame>
  );
}
