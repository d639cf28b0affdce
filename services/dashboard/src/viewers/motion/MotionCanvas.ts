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
  MeshStandardMaterial,
  PerspectiveCamera,
  Scene,
  Sphere,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const PLAIN = new Color("#8fc9c4");

/** A mesh whose vertices move. Draws only when something has. */
export class MotionCanvas {
  readonly canvas = document.createElement("canvas");
  readonly #renderer: WebGLRenderer;
  readonly #scene = new Scene();
  readonly #camera = new PerspectiveCamera(32, 1, 0.01, 1000);
  readonly #controls: OrbitControls;
  readonly #mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
  readonly #positions: BufferAttribute;
  readonly #resize: ResizeObserver;
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
    const geometry = new BufferGeometry();
    this.#positions = new BufferAttribute(new Float32Array(3 * vertices), 3);
    geometry.setAttribute("position", this.#positions);
    geometry.setIndex(new BufferAttribute(faces, 1));
    // Shading by face needs no normals, which would have to be computed anew for each frame.
    const material = new MeshStandardMaterial({ color: PLAIN, roughness: 0.6, side: DoubleSide, flatShading: true });
    this.#mesh = new Mesh(geometry, material);
    this.#mesh.frustumCulled = false;
    this.#scene.add(this.#mesh);
    this.#controls = new OrbitControls(this.#camera, this.canvas);
    this.#controls.addEventListener("change", this.draw);
    this.#resize = new ResizeObserver(() => this.#fit(parent));
    this.#resize.observe(parent);
    this.#fit(parent);
  }

  show(positions: Float32Array): void {
    this.#positions.array.set(positions);
    this.#positions.needsUpdate = true;
    if (!this.#looked) this.look();
    this.draw();
  }

  /** Color each vertex by its cluster; null colors all alike. */
  color(labels: Int32Array | null): void {
    const { geometry, material } = this.#mesh;
    if (labels) {
      const colors = new Float32Array(3 * labels.length);
      labels.forEach((label, v) => clusterColor(label).toArray(colors, 3 * v));
      geometry.setAttribute("color", new BufferAttribute(colors, 3));
    }
    material.vertexColors = labels !== null;
    material.color.set(labels ? "#ffffff" : PLAIN);
    material.needsUpdate = true;
    this.draw();
  }

  look(): void {
    const sphere = new Box3().setFromBufferAttribute(this.#positions).getBoundingSphere(new Sphere());
    if (!(sphere.radius > 0)) return;
    this.#looked = true;
    const distance =
      (sphere.radius * 1.25) / Math.sin((this.#camera.fov * Math.PI) / 360) / Math.min(1, this.#camera.aspect);
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
    this.#mesh.geometry.dispose();
    this.#mesh.material.dispose();
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
    this.canvas.remove();
  }

  draw = (): void => {
    this.#drawing ||= requestAnimationFrame(() => {
      this.#drawing = 0;
      this.#renderer.render(this.#scene, this.#camera);
    });
  };

  #fit(parent: HTMLElement): void {
    const { clientWidth: width, clientHeight: height } = parent;
    if (width === 0 || height === 0) return;
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
    this.draw();
  }
}

/** Colors that neighbouring numbers do not share: the hue turns by the golden ratio. */
function clusterColor(label: number): Color {
  return new Color().setHSL((label * 0.618034 + 0.08) % 1, 0.55, 0.6);
}
