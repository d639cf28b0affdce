import {
  Box3,
  Box3Helper,
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  Color,
  DoubleSide,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshStandardMaterial,
  Sphere,
  Sprite,
  SpriteMaterial,
  Vector3,
  WireframeGeometry,
} from "three";
import { Stage } from "../stage/Stage";
import type { Frame } from "./evolution";
import { readSurface, type SurfaceMesh } from "./readSurface";

export interface SurfaceSource {
  id: number;
  content: ArrayBuffer;
  color: string;
}

interface Surface {
  mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
  edges: LineSegments<WireframeGeometry, LineBasicMaterial> | null;
  color: Color;
  opacity: number;
}

const DIRECTIONS: readonly [string, Vector3][] = [
  ["R", new Vector3(1, 0, 0)],
  ["L", new Vector3(-1, 0, 0)],
  ["A", new Vector3(0, 1, 0)],
  ["P", new Vector3(0, -1, 0)],
  ["S", new Vector3(0, 0, 1)],
  ["I", new Vector3(0, 0, -1)],
];

/** Surfaces in space, in the frame they come in (RAS mm): up is the patient's head. Draws only when something moved. */
export class SurfaceCanvas {
  readonly stage: Stage;
  readonly #surfaces = new Map<number, Surface>();
  readonly #frame = new Group();
  /** Surfaces on their way; while there are any, nothing else is shown. */
  readonly #growing = new Group();
  #edges = false;
  #chosen: number | null = null;
  /** The sphere that one looked at last, and whether somebody has moved the camera since. */
  #seen = new Sphere();
  #moved = false;

  constructor(parent: HTMLElement, onLost: () => void) {
    this.stage = new Stage(parent, { up: [0, 0, 1], onHome: () => this.look(), onLost });
    this.stage.scene.add(this.#frame, this.#growing);
    this.#growing.visible = false;
    this.stage.controls.addEventListener("start", () => (this.#moved = true));
  }

  add({ id, content, color }: SurfaceSource): void {
    const geometry = geometryOf(readSurface(content));
    const mesh = new Mesh(geometry, matter(color));
    this.stage.scene.add(mesh);
    this.#surfaces.set(id, { mesh, edges: null, color: new Color(color), opacity: 1 });
    this.#restyle();
  }

  /** Show coarse surfaces in the place of all that were added; null shows those again. */
  grow(frames: readonly Frame[] | null, color: string): void {
    this.#clearGrowing();
    for (const { positions, faces } of frames ?? []) {
      this.#growing.add(new Mesh(geometryOf({ positions, faces }), matter(color)));
    }
    this.#growing.visible = frames !== null;
    this.#restyle();
  }

  /** Keep what grows in sight as long as nobody has moved the camera. */
  follow(): void {
    const box = new Box3().setFromObject(this.#growing);
    const { center, radius } = box.getBoundingSphere(new Sphere());
    if (!(radius > 0)) return;
    this.#letters(box);
    if (this.#moved) return;
    const away = center.distanceTo(this.#seen.center) + radius;
    // With room to grow into: a camera that steps back all the time would hide the growth.
    if (away > this.#seen.radius || radius < this.#seen.radius * 0.4) this.look(null, 1.6);
  }

  /** Look at everything from the front, a little from the right and above; or at one surface, keeping the direction.
   * `room` says how much larger than what there is. */
  look(id: number | null = null, room = 1): void {
    const box = new Box3();
    if (this.#growing.visible) box.expandByObject(this.#growing);
    else for (const [one, { mesh }] of this.#surfaces) if (id === null || id === one) box.expandByObject(mesh);
    if (box.isEmpty()) return;
    box.getBoundingSphere(this.#seen).radius *= room;
    this.#moved = false;
    const { camera, controls } = this.stage;
    const kept = new Vector3().subVectors(camera.position, controls.target);
    this.stage.lookAt(this.#seen, id === null ? new Vector3(0.45, 1, 0.4) : kept);
    this.#letters(box);
  }

  /** x, y, z of a surface's vertices, RAS mm. */
  positions(id: number): Float32Array {
    return new Float32Array(this.#surfaces.get(id)?.mesh.geometry.getAttribute("position").array ?? []);
  }

  /** Give each vertex of a surface a color of its own; null gives it back the one it came with. */
  tint(id: number, colors: Float32Array | null): void {
    const surface = this.#surfaces.get(id);
    if (!surface) return;
    const { geometry, material } = surface.mesh;
    if (colors) geometry.setAttribute("color", new BufferAttribute(colors, 3));
    else geometry.deleteAttribute("color");
    material.vertexColors = colors !== null;
    material.color.set(colors ? "#ffffff" : surface.color);
    this.#restyle();
  }

  /** Show a surface as far as `opacity` says; 0 hides it. */
  fade(id: number, opacity: number): void {
    const surface = this.#surfaces.get(id);
    if (!surface || surface.opacity === opacity) return;
    surface.opacity = opacity;
    this.#restyle();
  }

  drawEdges(on: boolean): void {
    this.#edges = on;
    this.#restyle();
  }

  /** Bring one surface out by letting the others fade; null shows all alike. */
  choose(id: number | null): void {
    this.#chosen = id;
    this.#restyle();
  }

  close(): void {
    for (const { mesh, edges } of this.#surfaces.values()) {
      mesh.geometry.dispose();
      mesh.material.dispose();
      edges?.geometry.dispose();
      edges?.material.dispose();
    }
    this.#clearGrowing();
    this.#clearLetters();
    this.stage.close();
  }

  #restyle(): void {
    for (const [id, surface] of this.#surfaces) {
      const faded = this.#chosen !== null && this.#chosen !== id;
      const { material } = surface.mesh;
      material.opacity = surface.opacity * (faded ? 0.28 : 1);
      material.transparent = material.opacity < 1;
      material.depthWrite = !material.transparent;
      surface.mesh.visible = surface.opacity > 0 && !this.#growing.visible;
      material.needsUpdate = true;
      if (this.#edges && !surface.edges) {
        const line = new LineBasicMaterial({
          color: surface.color.clone().multiplyScalar(0.3),
          transparent: true,
          opacity: 0.55,
        });
        surface.edges = new LineSegments(new WireframeGeometry(surface.mesh.geometry), line);
        surface.mesh.add(surface.edges);
        // Faces step back a little, or their own edges would flicker through them.
        material.polygonOffset = true;
        material.polygonOffsetFactor = 1;
        material.polygonOffsetUnits = 1;
      }
      if (surface.edges) surface.edges.visible = this.#edges && !faded;
    }
    this.stage.draw();
  }

  /** A thin box around what is seen, with the letters of the six directions. */
  #letters(box: Box3): void {
    this.#clearLetters();
    const size = box.getSize(new Vector3());
    const center = box.getCenter(new Vector3());
    const margin = Math.max(size.x, size.y, size.z) * 0.08;
    this.#frame.add(new Box3Helper(box.clone().expandByScalar(margin * 0.6), new Color("#3a4a4d")));
    for (const [letter, direction] of DIRECTIONS) {
      const sprite = new Sprite(new SpriteMaterial({ map: letterTexture(letter) }));
      sprite.scale.setScalar(margin * 1.5);
      const reach = size
        .clone()
        .multiplyScalar(0.5)
        .addScalar(margin * 1.5);
      sprite.position.copy(center).add(direction.clone().multiply(reach));
      this.#frame.add(sprite);
    }
  }

  #clearGrowing(): void {
    for (const child of [...this.#growing.children]) {
      this.#growing.remove(child);
      if (!(child instanceof Mesh)) continue;
      (child as Surface["mesh"]).geometry.dispose();
      (child as Surface["mesh"]).material.dispose();
    }
  }

  #clearLetters(): void {
    for (const child of [...this.#frame.children]) {
      this.#frame.remove(child);
      if (child instanceof Sprite) {
        child.material.map?.dispose();
        child.material.dispose();
      } else if (child instanceof Box3Helper) {
        child.dispose();
      }
    }
  }
}

function geometryOf({ positions, faces }: SurfaceMesh): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setIndex(new BufferAttribute(faces, 1));
  geometry.computeVertexNormals();
  return geometry;
}

function matter(color: string): MeshStandardMaterial {
  return new MeshStandardMaterial({ color, roughness: 0.5, metalness: 0.02, side: DoubleSide });
}

function letterTexture(letter: string): CanvasTexture {
  const canvas = document.createElement("canvas");
  canvas.width = 64;
  canvas.height = 64;
  const context = canvas.getContext("2d");
  if (context) {
    context.fillStyle = "#9fb4b6";
    context.font = "600 44px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(letter, 32, 34);
  }
  return new CanvasTexture(canvas);
}
