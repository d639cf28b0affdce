import { Niivue, NVDocument } from "@niivue/niivue";
import { linkLate } from "./linkLate";

type Options = NonNullable<ConstructorParameters<typeof Niivue>[0]>;

const OPTIONS: Options = {
  backColor: [0, 0, 0, 1],
  crosshairColor: [0.5, 0.78, 0.75, 0.55],
  crosshairWidth: 0.35,
  crosshairGap: 14,
  fontColor: [0.81, 0.87, 0.87, 1],
  fontMinPx: 12,
  fontSizeScaling: 0.35,
  isSliceMM: true,
  isOrientCube: false,
  isColorbar: false,
  multiplanarPadPixels: 6,
  show3Dcrosshair: true,
  meshThicknessOn2D: 0,
  meshXRay: 0.5,
  dragAndDropEnabled: false,
  scrollRequiresFocus: true,
  // Its single keys would change the layout behind the page's back.
  viewModeHotKey: "",
  clipPlaneHotKey: "",
  cycleClipPlaneHotKey: "",
  logLevel: "error",
  loadingText: "",
};

/** As large as niivue has its textures before there is a volume: frames of two voxels along each axis. */
const TINY = [2, 2, 2, 2];

/** The one that is kept for the page to come; it is not shown meanwhile. */
let kept: Viewer | null = null;

/**
 * niivue on a canvas of its own. Each compiles shaders, and a browser does not give back everything that a context took:
 * so one is kept and lent to one page after the other, its volumes freed in between.
 */
export class Viewer extends Niivue {
  /** Around the canvas; it is this that is put into a page and taken out, as niivue gives up without its parent. */
  readonly holder = document.createElement("div");
  override readonly canvas = document.createElement("canvas");
  /** Fulfilled when it can draw. */
  readonly ready: Promise<unknown>;
  onDrawn: (() => void) | null = null;
  onLost: (() => void) | null = null;
  readonly #still: Niivue["uiData"];
  /** Settings change, and are drawn together. */
  #waits = false;
  #usable = true; // its context is there

  /** One in its first state, shown in `parent`: the one that is kept, or a new one. */
  static borrow(parent: HTMLElement): Viewer {
    const viewer = kept ?? new Viewer();
    kept = null;
    parent.append(viewer.holder);
    return viewer;
  }

  private constructor() {
    super(OPTIONS);
    this.#free("volumeObject3D");
    this.#free("crosshairs3D");
    this.#still = structuredClone(this.uiData);
    this.holder.style.cssText = "width: 100%; height: 100%";
    this.holder.append(this.canvas);
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "The volume.");
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.#usable = false;
      this.onLost?.();
    });
    this.ready = this.attachToCanvas(this.canvas);
    this.ready.catch(() => {
      this.#usable = false;
    });
  }

  /** Take one out of its page; whoever borrowed it is done with it. */
  static giveBack(viewer: Viewer): void {
    viewer.holder.remove();
    viewer.onDrawn = null;
    viewer.onLost = null;
    viewer.onLocationChange = () => undefined;
    if (kept || !viewer.#usable) {
      viewer.#end();
    } else {
      kept = viewer;
      viewer.#clear();
    }
  }

  #end(): void {
    this.cleanup();
    // A browser keeps a handful of contexts; one that is only forgotten counts until it is collected.
    this.canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** Free what it shows, and go back to the first state. */
  #clear(): void {
    for (const mesh of this.meshes) mesh.unloadMesh(this.gl);
    this.document = new NVDocument();
    Object.assign(this.opts, OPTIONS);
    Object.assign(this.uiData, structuredClone(this.#still));
    this.customLayout = [];
    this.screenSlices = [];
    this.back = null;
    this.overlays = [];
    this.volumeObject3D = null;
    this.crosshairs3D = null;
    const { gl } = this;
    this.volumeTexture = this.rgbaTex(this.volumeTexture, gl.TEXTURE0, TINY, true);
    this.overlayTexture = this.rgbaTex(this.overlayTexture, gl.TEXTURE2, TINY, true);
    this.overlayTextureID = this.overlayTexture;
    gl.deleteTexture(this.gradientTexture);
    this.gradientTexture = null;
    this.canvas.width = this.canvas.height = 1;
  }

  /** niivue forgets its box around the volume, and its crosshair, each time it makes another; the browser does not. */
  #free(name: "volumeObject3D" | "crosshairs3D"): void {
    let held = this[name];
    Object.defineProperty(this, name, {
      get: () => held,
      set: (next: typeof held) => {
        if (held && held !== next) {
          const { gl } = this;
          gl.deleteVertexArray(held.vao);
          gl.deleteBuffer(held.vertexBuffer);
          gl.deleteBuffer(held.indexBuffer);
        }
        held = next;
      },
    });
  }

  /** Pixels of the canvas along each side of one of the page, 0 for as many as the screen has; draws nothing yet. */
  sharpen(ratio: number): void {
    if (this.opts.forceDevicePixelRatio === ratio) return;
    this.opts.forceDevicePixelRatio = ratio;
    this.#waits = true;
    this.resizeListener();
    this.#waits = false;
  }

  override init(): Promise<this> {
    linkLate(this.gl);
    return super.init();
  }

  override drawScene(): ReturnType<Niivue["drawScene"]> {
    if (this.#waits) return;
    const told = super.drawScene();
    this.onDrawn?.();
    return told;
  }

  override rgbaTex(texture: WebGLTexture | null, unit: number, dims: number[], cleared = false): WebGLTexture | null {
    const { TEXTURE2, TEXTURE6, TEXTURE8 } = this.gl;
    // niivue forgets the labels' texture each time it mixes their colors anew; it is the size of the volume.
    if (unit === TEXTURE2) return super.rgbaTex(texture ?? this.overlayTexture, unit, dims, cleared);
    // It computes gradients for a way to light the volume that is not used here, at most of the time that a volume
    // takes to be drawn at first: they are left with one voxel in each slice.
    if (unit === TEXTURE6 || (unit === TEXTURE8 && cleared)) {
      const [count = 0, , , depth = 0] = dims;
      return super.rgbaTex(texture, unit, [count, 1, 1, depth], cleared);
    }
    return super.rgbaTex(texture, unit, dims, cleared);
  }
}
