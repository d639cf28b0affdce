import {
  AmbientLight,
  Box3,
  DirectionalLight,
  HemisphereLight,
  PerspectiveCamera,
  Quaternion,
  Scene,
  Sphere,
  Spherical,
  Vector3,
  type WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { borrowRenderer, giveBackRenderer, keepPrograms } from "./renderers";

interface StageOptions {
  /** What is above in the picture; the y axis where nothing is said. */
  up?: [number, number, number];
  /** Where the light comes from, as seen from the camera. */
  light?: [number, number, number];
  /** Looks at everything again: the key Home. */
  onHome: () => void;
  /** The graphics driver took the picture away. */
  onLost: () => void;
}

const TURNS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-0.12, 0],
  ArrowRight: [0.12, 0],
  ArrowUp: [0, -0.12],
  ArrowDown: [0, 0.12],
};
const ZOOMS: Readonly<Record<string, number>> = { "+": 0.9, "=": 0.9, "-": 1.11 };

/**
 * A lit scene on a canvas that fills its parent, looked at by a camera that drags, wheels and keys turn: arrows turn
 * around, plus and minus come nearer and go away, Home looks at everything. Draws only when something has changed.
 */
export class Stage {
  readonly renderer: WebGLRenderer = borrowRenderer();
  readonly canvas = this.renderer.domElement;
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(32, 1, 0.01, 4000);
  readonly controls: OrbitControls;
  /** Of the picture, in CSS pixels. */
  width = 1;
  height = 1;
  /** Draws the scene; others may draw it in parts. */
  render = (): void => this.renderer.render(this.scene, this.camera);
  readonly #options: StageOptions;
  readonly #resize: ResizeObserver;
  #drawing = 0;
  #closed = false;

  constructor(parent: HTMLElement, options: StageOptions) {
    this.#options = options;
    this.canvas.tabIndex = 0;
    parent.append(this.canvas);
    this.camera.up.set(...(options.up ?? [0, 1, 0]));
    const light = new DirectionalLight("#ffffff", 2);
    light.position.set(...(options.light ?? [0.4, 0.7, 1]));
    this.camera.add(light);
    this.scene.add(this.camera, new HemisphereLight("#dfeeee", "#3a4a50", 1.1), new AmbientLight("#ffffff", 0.25));
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", this.draw);
    this.canvas.addEventListener("keydown", this.#key);
    this.canvas.addEventListener("webglcontextlost", this.#lost);
    this.#resize = new ResizeObserver(() => this.#fit(parent));
    this.#resize.observe(parent);
    this.#fit(parent);
  }

  /** What tests and those who do not see it know it by. */
  tell(label: string, testId: string): void {
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${label} Arrow keys turn it, plus and minus zoom, Home shows all of it.`);
    this.canvas.dataset.testid = testId;
  }

  /** Look at a sphere from a direction, so that it fills the view; `share` of the width is there for it. */
  lookAt({ center, radius }: Sphere, towards: Vector3, share = 1): void {
    const narrow = Math.min(1, (share * this.width) / this.height);
    const distance = (radius * 1.1) / Math.sin((this.camera.fov * Math.PI) / 360) / narrow;
    this.#look(center, towards.clone().normalize(), distance);
  }

  /** Look from a direction so that all of some spheres are seen, as large as the shape of the picture allows. */
  lookAtAll(spheres: readonly Sphere[], towards: Vector3, share = 1): void {
    const away = towards.clone().normalize();
    const right = new Vector3().crossVectors(this.camera.up, away).normalize();
    const above = new Vector3().crossVectors(away, right);
    const box = new Box3();
    for (const { center, radius } of spheres) {
      const at = new Vector3(center.dot(right), center.dot(above), center.dot(away));
      box.expandByPoint(at.clone().addScalar(radius)).expandByPoint(at.subScalar(radius));
    }
    const middle = box.getCenter(new Vector3());
    const half = (this.camera.fov * Math.PI) / 360;
    const across = Math.atan(Math.tan(half) * ((share * this.width) / this.height));
    const distance = Math.max(
      ...spheres.map(({ center, radius }) => {
        const [x, y] = [Math.abs(center.dot(right) - middle.x), Math.abs(center.dot(above) - middle.y)];
        const nearer = center.dot(away) - middle.z;
        return (
          nearer +
          Math.max(x / Math.tan(across) + radius / Math.sin(across), y / Math.tan(half) + radius / Math.sin(half))
        );
      }),
    );
    this.#look(
      new Vector3().addScaledVector(right, middle.x).addScaledVector(above, middle.y).addScaledVector(away, middle.z),
      away,
      distance,
    );
  }

  /** Whether a sphere lies within the picture as it is. */
  sees({ center, radius }: Sphere, share = 1): boolean {
    const seen = this.camera.worldToLocal(center.clone());
    const half = (this.camera.fov * Math.PI) / 360;
    const across = Math.atan(Math.tan(half) * ((share * this.width) / this.height));
    const within = (beside: number, angle: number) =>
      -seen.z * Math.sin(angle) - Math.abs(beside) * Math.cos(angle) >= radius;
    return within(seen.x, across) && within(seen.y, half);
  }

  #look(target: Vector3, towards: Vector3, distance: number): void {
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(towards, distance);
    this.camera.near = distance / 100;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.draw();
  }

  draw = (): void => {
    if (this.#drawing || this.#closed) return;
    this.#drawing = requestAnimationFrame(() => {
      this.#drawing = 0;
      this.render();
      keepPrograms(this.renderer);
    });
  };

  /** Whoever has put something into the scene has disposed of it. */
  close(): void {
    if (this.#closed) return;
    this.#closed = true;
    cancelAnimationFrame(this.#drawing);
    this.#resize.disconnect();
    this.controls.dispose();
    this.canvas.removeEventListener("keydown", this.#key);
    this.canvas.removeEventListener("webglcontextlost", this.#lost);
    giveBackRenderer(this.renderer);
  }

  #fit(parent: HTMLElement): void {
    const { clientWidth: width, clientHeight: height } = parent;
    if (width === 0 || height === 0) return;
    [this.width, this.height] = [width, height];
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  #lost = (event: Event) => {
    event.preventDefault();
    this.#options.onLost();
  };

  #key = (event: KeyboardEvent) => {
    const turn = TURNS[event.key];
    const zoom = ZOOMS[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey || !(turn || zoom || event.key === "Home")) return;
    event.preventDefault();
    if (event.key === "Home") {
      this.#options.onHome();
      return;
    }
    // As the controls do: in a frame whose y axis is up.
    const upright = new Quaternion().setFromUnitVectors(this.camera.up, new Vector3(0, 1, 0));
    const { target } = this.controls;
    const offset = new Vector3().subVectors(this.camera.position, target).applyQuaternion(upright);
    const at = new Spherical().setFromVector3(offset);
    at.radius *= zoom ?? 1;
    at.theta += turn?.[0] ?? 0;
    at.phi = Math.min(Math.max(at.phi + (turn?.[1] ?? 0), 0.05), Math.PI - 0.05);
    offset.setFromSpherical(at).applyQuaternion(upright.invert());
    this.camera.position.copy(target).add(offset);
    this.controls.dispatchEvent({ type: "start" });
    this.controls.update();
    this.draw();
  };
}
