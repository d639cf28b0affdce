import { type Niivue, NVImage, NVMesh, SLICE_TYPE } from "@niivue/niivue";
import { LABELS, REFERENCE_COLOR, rgb } from "../labels";
import type { SurfaceMesh } from "../surface/readSurface";
import type { SliceView } from "./box";
import { drawsBySoftware } from "../webgl";
import type { Drawn } from "./niftiStream";
import { coarserAffine } from "./reduce";
import { Viewer } from "./Viewer";

export type VolumeLayout = "slices" | "axial" | "coronal" | "sagittal" | "render";

/** Where the crosshair is, and what is there. */
export interface Place {
  /** RAS, in mm. */
  mm: [number, number, number];
  intensity: number | null;
  label: number;
}

export interface Display {
  layout: VolumeLayout;
  /** Of the labels, in [0, 1]. */
  opacity: number;
  /** Of each label on its own, and of the surface that bounds it, in [0, 1]; 1 where nothing is said. */
  layers: Readonly<Record<number, number>>;
  /** Of the volume where it is seen as a whole, in [0, 1]. */
  volumeOpacity: number;
  /** Of the reference mask, in [0, 1]. */
  referenceOpacity: number;
  /** Only the labels' outlines are drawn on slices. */
  outline: boolean;
  /** The patient's left on the right side of the picture, as radiologists look. */
  radiological: boolean;
  /** Intensities that are black and white. */
  window: [number, number];
}

export interface Source extends Drawn {
  /** With the extension that tells the format. */
  name: string;
}

export interface Intensities {
  /** The darkest and the brightest. */
  range: [number, number];
  /** Black and white of a good first picture. */
  window: [number, number];
  /** Whether the volume is so large that it is drawn coarser than it is. */
  coarse: boolean;
}

/** What niivue tells of a place; its own type leaves the argument open. */
interface Location {
  mm: ArrayLike<number>;
  values: { value: number }[];
}

/** Voxels that are drawn at the most: the picture of each takes four bytes, and as many again with an overlay. */
export function mostVoxels(): number {
  return drawsBySoftware() ? 2 ** 24 : 2 ** 26;
}

/** The axes of a slice: across, upwards, through. */
const AXES: Partial<Record<SLICE_TYPE, [0 | 1, 1 | 2, 0 | 1 | 2]>> = {
  [SLICE_TYPE.AXIAL]: [0, 1, 2],
  [SLICE_TYPE.CORONAL]: [0, 2, 1],
  [SLICE_TYPE.SAGITTAL]: [1, 2, 0],
};

const TYPES = {
  axial: SLICE_TYPE.AXIAL,
  coronal: SLICE_TYPE.CORONAL,
  sagittal: SLICE_TYPE.SAGITTAL,
  render: SLICE_TYPE.RENDER,
} as const;

/** Axial large, as it is read first; the others beside it. Each: left, top, width, height. */
const SLICES: Niivue["customLayout"] = [
  { sliceType: SLICE_TYPE.AXIAL, position: [0, 0, 0.58, 1] },
  { sliceType: SLICE_TYPE.CORONAL, position: [0.58, 0, 0.42, 0.5] },
  { sliceType: SLICE_TYPE.SAGITTAL, position: [0.58, 0.5, 0.42, 0.5] },
];

/** niivue behind the few things that the page wants of it; the volume in the frame RAS mm, as everywhere. */
export class VolumeCanvas {
  readonly canvas: HTMLCanvasElement;
  readonly #viewer: Viewer;
  #closed = false;
  #shown: Display | null = null;
  #reference: NVImage | null = null;
  #wanted = 0;
  readonly #surfaces = new Map<string, { label: number; mesh: NVMesh }>();

  constructor(parent: HTMLElement, onPlace: (place: Place) => void, onLost: () => void) {
    this.#viewer = Viewer.borrow(parent);
    this.canvas = this.#viewer.canvas;
    this.#viewer.onLocationChange = (location) => onPlace(placeOf(location as Location));
    this.#viewer.onLost = onLost;
    this.canvas.addEventListener("keydown", this.#key);
  }

  /** Draw a volume, with labels over it where there are any; tells the window that it chose, and the intensities. */
  async open(image: Source, labels: Source | null, display: Omit<Display, "window">): Promise<Intensities> {
    const viewer = this.#viewer;
    await viewer.ready;
    const [base, overlay] = await Promise.all([read(image, "gray"), labels ? read(labels) : null]);
    const coarse = Math.max(...image.steps) > 1;
    const window: [number, number] = [base.robust_min ?? base.cal_min ?? 0, base.robust_max ?? base.cal_max ?? 1];
    const range: [number, number] = [base.global_min ?? window[0], base.global_max ?? window[1]];
    if (this.#closed) return { range, window, coarse };
    this.#arrange(display);
    if (overlay) {
      overlay.setColormapLabel(labelColors(display.layers, NONE));
      overlay.opacity = display.opacity;
    }
    viewer.volumes = overlay ? [base, overlay] : [base];
    viewer.setVolume(base, 0); // draws all of them
    this.#shown = { ...display, window };
    viewer.createOnLocationChange(); // where the crosshair is at first is told, too
    return { range, window, coarse };
  }

  /** Lay a mask over everything else, in a color of its own; null takes it away. */
  async lay(reference: Source | null, opacity: number): Promise<void> {
    const wanted = (this.#wanted += 1);
    const mask = reference ? await read(reference) : null;
    if (this.#closed || wanted !== this.#wanted) return;
    if (this.#reference) this.#viewer.removeVolume(this.#reference);
    this.#reference = mask;
    if (!mask) return;
    mask.setColormapLabel(referenceColors(Math.min(mask.global_max ?? 1, 255)));
    mask.opacity = opacity;
    this.#viewer.addVolume(mask);
  }

  /** Whether a surface was added under this name. */
  has(name: string): boolean {
    return this.#surfaces.has(name);
  }

  /** Draw surfaces where the volume is seen as a whole, in the colors of the labels that they bound. */
  addSurfaces(surfaces: readonly { name: string; label: number; surface: SurfaceMesh }[]): void {
    if (this.#closed) return;
    const viewer = this.#viewer;
    for (const { name, label, surface } of surfaces) {
      const [red, green, blue] = rgb(LABELS.find(({ value }) => value === label)?.color ?? REFERENCE_COLOR);
      const color = new Uint8Array([red, green, blue, 255]);
      const mesh = new NVMesh(surface.positions, surface.faces, name, color, 1, true, viewer.gl);
      this.#surfaces.set(name, { label, mesh });
      // niivue's own way to add one draws everything anew each time.
      viewer.meshes = [...viewer.meshes, mesh];
    }
    const display = this.#shown;
    this.#shown = null;
    if (display) this.show(display);
  }

  show(display: Display): void {
    const viewer = this.#viewer;
    const base = viewer.volumes[0];
    const overlay = viewer.volumes.find((volume, index) => index > 0 && volume !== this.#reference);
    const before = this.#shown;
    if (!base || before === display) return;
    this.#shown = display;
    this.#arrange(display);
    // Colors are mixed anew for every voxel, which takes a while where the processor does it: only when they change.
    if (
      before?.window[0] === display.window[0] &&
      before.window[1] === display.window[1] &&
      before.opacity === display.opacity &&
      before.referenceOpacity === display.referenceOpacity &&
      before.layers === display.layers &&
      before.volumeOpacity === display.volumeOpacity &&
      (before.layout === "render") === (display.layout === "render") &&
      before.outline === display.outline
    ) {
      viewer.drawScene();
      return;
    }
    [base.cal_min, base.cal_max] = display.window;
    const solid = display.layout === "render";
    base.opacity = solid ? display.volumeOpacity : 1;
    const bounded = new Set(solid ? [...this.#surfaces.values()].map(({ label }) => label) : []);
    // What an object encloses lies behind its surface.
    if (bounded.has(1)) bounded.add(2);
    if (overlay) {
      overlay.setColormapLabel(labelColors(display.layers, bounded));
      overlay.opacity = solid ? 1 : display.opacity;
    }
    for (const { label, mesh } of this.#surfaces.values()) {
      mesh.opacity = display.layers[label] ?? 1;
      mesh.visible = mesh.opacity > 0;
    }
    if (this.#reference) this.#reference.opacity = display.referenceOpacity;
    viewer.updateGLVolume();
  }

  #arrange({ layout, radiological, outline }: Omit<Display, "window">): void {
    const { opts } = this.#viewer;
    opts.isRadiologicalConvention = radiological;
    opts.atlasOutline = outline ? 1 : 0;
    // niivue's own setters draw at once, with half of the settings.
    if (layout === "slices") {
      this.#viewer.customLayout = SLICES;
    } else {
      this.#viewer.customLayout = [];
      opts.sliceType = TYPES[layout];
    }
    // To look through a volume takes a processor seconds: there it does so for a quarter of the pixels.
    this.#viewer.sharpen(layout === "render" && drawsBySoftware() ? 0.5 : 0);
  }

  /** Move the crosshair to a point given in RAS mm. */
  goTo([x, y, z]: readonly [number, number, number]): void {
    const viewer = this.#viewer;
    if (viewer.volumes.length === 0) return;
    viewer.scene.crosshairPos = viewer.mm2frac([x, y, z]);
    viewer.createOnLocationChange();
    viewer.drawScene();
  }

  /** Tell the slices now, and each time they were drawn, until what this returns is called. */
  watch(told: (views: SliceView[]) => void): () => void {
    this.#viewer.onDrawn = () => told(this.views());
    this.#viewer.onDrawn();
    return () => {
      this.#viewer.onDrawn = null;
    };
  }

  /** The slices as they were drawn last. */
  views(): SliceView[] {
    const ratio = this.canvas.width / Math.max(this.canvas.clientWidth, 1);
    return this.#viewer.screenSlices.flatMap(({ axCorSag, leftTopWidthHeight, leftTopMM, fovMM }) => {
      const axes = AXES[axCorSag];
      const [left = 0, top = 0, width = 0, height = 0] = leftTopWidthHeight.map((value) => value / ratio);
      const [lowAcross = 0, lowUp = 0] = leftTopMM;
      const [acrossMM = 1, sizeUp = 1] = fovMM;
      if (!axes) return [];
      const [across, up, through] = axes;
      return {
        across,
        up,
        through,
        left: Math.min(left, left + width),
        top,
        width: Math.abs(width),
        height,
        mirrored: width < 0 !== acrossMM < 0,
        low: [Math.min(lowAcross, lowAcross + acrossMM), lowUp] as const,
        size: [Math.abs(acrossMM), sizeUp] as const,
      };
    });
  }

  /** Move the crosshair along an axis, in voxels. */
  step(axis: 0 | 1 | 2, by: number): void {
    this.#viewer.moveCrosshairInVox(axis === 0 ? by : 0, axis === 1 ? by : 0, axis === 2 ? by : 0);
  }

  close(): void {
    if (this.#closed) return;
    this.#closed = true;
    this.canvas.removeEventListener("keydown", this.#key);
    Viewer.giveBack(this.#viewer);
  }

  /** Arrows move the crosshair in the axial plane, page up and page down through it. */
  #key = (event: KeyboardEvent) => {
    const steps: Record<string, [number, number, number]> = {
      ArrowLeft: [-1, 0, 0],
      ArrowRight: [1, 0, 0],
      ArrowDown: [0, -1, 0],
      ArrowUp: [0, 1, 0],
      PageDown: [0, 0, -1],
      PageUp: [0, 0, 1],
    };
    const step = steps[event.key];
    if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const [x, y, z] = step;
    this.#viewer.moveCrosshairInVox(this.#viewer.opts.isRadiologicalConvention ? -x : x, y, z);
  };
}

async function read({ name, content, steps }: Source, colormap = ""): Promise<NVImage> {
  const image = await NVImage.loadFromUrl({ url: name, name, buffer: content, colormap });
  if (Math.max(...steps) > 1 && image.hdr) place(image, coarserAffine(image.hdr.affine, steps));
  return image;
}

/** Put a volume somewhere else in space: its voxels have become larger. */
function place(image: NVImage, affine: number[][]): void {
  const { hdr } = image;
  if (!hdr) return;
  hdr.pixDims = hdr.pixDims.map((length, axis) =>
    axis >= 1 && axis <= 3 ? Math.hypot(...affine.slice(0, 3).map((row) => row[axis - 1] ?? 0)) : length,
  );
  image.setAffine(affine);
}

function placeOf({ mm, values }: Location): Place {
  return {
    mm: [mm[0] ?? 0, mm[1] ?? 0, mm[2] ?? 0],
    intensity: values[0]?.value ?? null,
    label: Math.round(values[1]?.value ?? 0),
  };
}

/** Every value of a mask but nothing in one color. */
function referenceColors(largest: number) {
  const values = Array.from({ length: Math.max(Math.round(largest), 1) }, (_, index) => index + 1);
  const [red, green, blue] = rgb(REFERENCE_COLOR);
  return {
    R: [0, ...values.map(() => red)],
    G: [0, ...values.map(() => green)],
    B: [0, ...values.map(() => blue)],
    A: [0, ...values.map(() => 255)],
    I: [0, ...values],
    labels: ["", ...values.map(() => "Reference")],
  };
}

const NONE: ReadonlySet<number> = new Set();

/** The labels' colors as far as their layers are seen, without those in `hidden`. */
function labelColors(layers: Display["layers"], hidden: ReadonlySet<number>) {
  const colors = LABELS.map(({ color }) => rgb(color));
  return {
    R: [0, ...colors.map(([red]) => red)],
    G: [0, ...colors.map(([, green]) => green)],
    B: [0, ...colors.map(([, , blue]) => blue)],
    A: [0, ...LABELS.map(({ value }) => (hidden.has(value) ? 0 : Math.round(255 * (layers[value] ?? 1))))],
    I: [0, ...LABELS.map(({ value }) => value)],
    labels: ["", ...LABELS.map(({ name }) => name)],
  };
}
