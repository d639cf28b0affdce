import {
  AmbientLight,
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  PerspectiveCamera,
  Scene,
  Sphere,
  Vector3,
  WebGLRenderer,
} from "three";
import { errorColor } from "./errorColors";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const PLAIN = new Color("#8fc9c4");
const ORIGINAL = new Color("#d8c7a6");

export type Layout = "decoded" | "original" | "beside" | "overlaid";
export type Coloring = "plain" | "clusters" | "error";

/** What the original differs by, in one frame. */
export interface Difference {
  residuals: Int8Array;
  step: number;
  /** The error that has the last color. */
  most: number;
}

/** A mesh whose vertices move, alone, beside or over its original. Draws only when something has changed. */
export class MotionCanvas {
  readonly canvas = document.createElement("canvas");
  readonly #renderer: WebGLRenderer;
  readonly #scene = new Scene();
  readonly #camera = new PerspectiveCamera(32, 1, 0.01, 1000);
  readonly #controls: OrbitControls;
  readonly #mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
  readonly #original: Mesh<BufferGeometry, MeshStandardMaterial>;
  readonly #wires: Mesh<BufferGeometry, MeshBasicMaterial>;
  readonly #positions: BufferAttribute;
  readonly #before: BufferAttribute;
  readonly #colors: BufferAttribute;
  readonly #resize: ResizeObserver;
  #layout: Layout = "decoded";
  #coloring: Coloring = "plain";
  #size = { width: 1, height: 1 };
  #drawing = 0;
  #looked = false;

  constructor(parent: HTMLElement, vertices: number, faces: Uint32Array) {
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    parent.append(this.canvas);
    this.#renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true });
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.#renderer.setClearColor("#000000");
    const light = new DirectionalLight("#ffffff", 2);
    light.position.set(0.4, 0.7, 1);
    this.#camera.add(light);
    this.#scene.add(this.#camera, new HemisphereLight("#dfeeee", "#3a4a50", 1.1), new AmbientLight("#ffffff", 0.25));
    const index = new BufferAttribute(faces, 1);
    const attribute = () => new BufferAttribute(new Float32Array(3 * vertices), 3);
    [this.#positions, this.#before, this.#colors] = [attribute(), attribute(), attribute()];
    const geometry = new BufferGeometry().setIndex(index);
    geometry.setAttribute("position", this.#positions).setAttribute("color", this.#colors);
    const before = new BufferGeometry().setIndex(index);
    before.setAttribute("position", this.#before);
    // Shading by face needs no normals, which would have to be computed anew for each frame.
    const material = (color: Color) =>
      new MeshStandardMaterial({ color, roughness: 0.6, side: DoubleSide, flatShading: true });
    this.#mesh = new Mesh(geometry, material(PLAIN));
    this.#original = new Mesh(before, material(ORIGINAL));
    this.#wires = new Mesh(
      before,
      new MeshBasicMaterial({ color: "#ffb454", wireframe: true, transparent: true, opacity: 0.55 }),
    );
    for (const mesh of [this.#mesh, this.#original, this.#wires]) {
      mesh.frustumCulled = false;
      this.#scene.add(mesh);
    }
    this.#controls = new OrbitControls(this.#camera, this.canvas);
    this.#controls.addEventListener("change", this.draw);
    this.#resize = new ResizeObserver(() => this.#fit(parent));
    this.#resize.observe(parent);
    this.#fit(parent);
    this.arrange("decoded", "plain", null);
  }

  /** Show a frame; `difference` is needed where the original or the error is shown. */
  show(positions: Float32Array, difference: Difference | null): void {
    this.#positions.array.set(positions);
    this.#positions.needsUpdate = true;
    if (difference && this.#layout !== "decoded") {
      const { residuals, step } = difference;
      const to = this.#before.array;
      for (let at = 0; at < to.length; at += 1) {
        to[at] = (positions[at] as number) + step * (residuals[at] as number);
      }
      this.#before.needsUpdate = true;
    }
    if (difference && this.#coloring === "error") {
      const { residuals, step, most } = difference;
      const colors = this.#colors.array as Float32Array;
      for (let at = 0; at < colors.length; at += 3) {
        const error = Math.hypot(residuals[at] as number, residuals[at + 1] as number, residuals[at + 2] as number);
        errorColor(most > 0 ? (step * error) / most : 0, colors, at);
      }
      this.#colors.needsUpdate = true;
    }
    if (!this.#looked) this.look();
    this.draw();
  }

  /** Choose what is drawn where, and by what the decoded mesh is colored. */
  arrange(layout: Layout, coloring: Coloring, labels: Int32Array | null): void {
    this.#layout = layout;
    this.#coloring = coloring;
    if (coloring === "clusters" && labels) {
      labels.forEach((label, v) => clusterColor(label).toArray(this.#colors.array, 3 * v));
      this.#colors.needsUpdate = true;
    }
    const { material } = this.#mesh;
    material.vertexColors = coloring !== "plain";
    material.color.set(coloring === "plain" ? PLAIN : "#ffffff");
    material.needsUpdate = true;
    this.draw();
  }

  look(): void {
    const sphere = new Box3().setFromBufferAttribute(this.#positions).getBoundingSphere(new Sphere());
    if (!(sphere.radius > 0)) return;
    this.#looked = true;
    const { width, height } = this.#size;
    const aspect = (this.#layout === "beside" ? 0.5 : 1) * (width / Math.max(height, 1));
    const distance = (sphere.radius * 1.25) / Math.sin((this.#camera.fov * Math.PI) / 360) / Math.min(1, aspect);
    this.#controls.target.copy(sphere.center);
    this.#camera.position.copy(sphere.center).addScaledVector(new Vector3(0.5, 0.35, 1).normalize(), distance);
    this.#camera.near = distance / 100;
    this.#camera.far = distance * 20;
    this.#camera.updateProjectionMatrix();
    this.#controls.update();
    this.draw();
  }

  close(): void {
    cancelAnimationFrame(this.#drawing);
    this.#resize.disconnect();
    this.#controls.dispose();
    for (const mesh of [this.#mesh, this.#original, this.#wires]) {
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
    this.canvas.remove();
  }

  draw = (): void => {
    this.#drawing ||= requestAnimationFrame(() => {
      this.#drawing = 0;
      const { width, height } = this.#size;
      if (this.#layout !== "beside") {
        this.#view(0, width, height, this.#layout !== "original", this.#layout === "original");
        return;
      }
      const half = Math.floor(width / 2);
      this.#view(0, half - 1, height, false, true);
      this.#view(half, width - half, height, true, false);
    });
  };

  /** Draw into a part of the canvas. */
  #view(left: number, width: number, height: number, decoded: boolean, original: boolean): void {
    this.#mesh.visible = decoded;
    this.#original.visible = original;
    this.#wires.visible = this.#layout === "overlaid";
    this.#camera.aspect = width / Math.max(height, 1);
    this.#camera.updateProjectionMatrix();
    this.#renderer.setScissorTest(true);
    this.#renderer.setScissor(left, 0, width, height);
    this.#renderer.setViewport(left, 0, width, height);
    this.#renderer.render(this.#scene, this.#camera);
  }

  #fit(parent: HTMLElement): void {
    const { clientWidth: width, clientHeight: height } = parent;
    if (width === 0 || height === 0) return;
    this.#renderer.setSize(width, height, false);
    this.#size = { width, height };
    this.draw();
  }
}

/** Colors that neighbouring numbers do not share: the hue turns by the golden ratio. */
function clusterColor(label: number): Color {
  return new Color().setHSL((label * 0.618034 + 0.08) % 1, 0.55, 0.6);
}
