import {
  BufferAttribute,
  BufferGeometry,
  Color,
  Mesh,
  MeshBasicMaterial,
  type ShaderMaterial,
  Sphere,
  Vector3,
} from "three";
import { type Ball, ballOf } from "@/features/motion/reach";
import { Stage } from "../stage/Stage";
import type { SurfaceMesh } from "../surface/readSurface";
import { drawsBySoftware } from "../webgl";
import { errorColor } from "./errorColors";
import { faceted } from "./faceted";
import { isSolid } from "./solid";

const PLAIN = "#8fc9c4";
const ORIGINAL = "#d8c7a6";

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
  readonly stage: Stage;
  readonly #mesh: Mesh<BufferGeometry, ShaderMaterial>;
  readonly #original: Mesh<BufferGeometry, ShaderMaterial>;
  readonly #wires: Mesh<BufferGeometry, MeshBasicMaterial>;
  readonly #positions: BufferAttribute;
  readonly #before: BufferAttribute;
  readonly #colors: BufferAttribute;
  #layout: Layout = "decoded";
  #coloring: Coloring = "plain";
  /** Around the mesh in some frames: what one looks at. */
  readonly #spheres: Sphere[] = [];
  readonly #faces: Uint32Array;
  #first = true;
  /** Whether only front faces are ever seen. */
  #solid = false;
  /** Whether somebody has moved the camera since one looked. */
  #moved = false;

  constructor(parent: HTMLElement, vertices: number, faces: Uint32Array, onLost: () => void) {
    this.stage = new Stage(parent, { onHome: () => this.look(), onLost });
    this.stage.render = () => this.#render();
    this.stage.controls.addEventListener("start", () => (this.#moved = true));
    this.#faces = faces;
    const index = new BufferAttribute(faces, 1);
    const attribute = () => new BufferAttribute(new Float32Array(3 * vertices), 3);
    [this.#positions, this.#before, this.#colors] = [attribute(), attribute(), attribute()];
    const geometry = new BufferGeometry().setIndex(index);
    geometry.setAttribute("position", this.#positions).setAttribute("color", this.#colors);
    const before = new BufferGeometry().setIndex(index);
    before.setAttribute("position", this.#before);
    this.#mesh = new Mesh(geometry, faceted({ paint: PLAIN, colored: false, solid: false }));
    this.#original = new Mesh(before, faceted({ paint: ORIGINAL, colored: false, solid: false }));
    this.#wires = new Mesh(
      before,
      new MeshBasicMaterial({ color: "#ffb454", wireframe: true, transparent: true, opacity: 0.55 }),
    );
    for (const mesh of [this.#mesh, this.#original, this.#wires]) {
      mesh.frustumCulled = false;
      this.stage.scene.add(mesh);
    }
    this.arrange("decoded", "plain", null);
  }

  /** Show a frame; `difference` is needed where the original or the error is shown. */
  show(positions: Float32Array, difference: Difference | null): void {
    if (this.#first && drawsBySoftware()) {
      this.#solid = isSolid(positions, this.#faces);
      this.#shade();
    }
    this.#first = false;
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
    this.#keepInSight(ballOf(positions));
    this.stage.draw();
  }

  /** The decoded mesh as it is shown. */
  mesh(): SurfaceMesh {
    return { positions: new Float32Array(this.#positions.array), faces: new Uint32Array(this.#faces) };
  }

  /** Choose what is drawn where, and by what the decoded mesh is colored. */
  arrange(layout: Layout, coloring: Coloring, labels: Int32Array | null): void {
    this.#layout = layout;
    this.#coloring = coloring;
    if (coloring === "clusters" && labels) {
      labels.forEach((label, v) => clusterColor(label).toArray(this.#colors.array, 3 * v));
      this.#colors.needsUpdate = true;
    }
    this.#shade();
    this.stage.draw();
  }

  /** Look at where the mesh will be. */
  expect(balls: readonly Ball[]): void {
    this.#spheres.push(...balls.map(([x, y, z, radius]) => new Sphere(new Vector3(x, y, z), radius)));
    this.look();
  }

  /** Step back as far as a frame needs, unless somebody has chosen where to look from. */
  #keepInSight([x, y, z, radius]: Ball): void {
    if (this.#moved) return;
    const sphere = new Sphere(new Vector3(x, y, z), radius);
    if (this.#spheres.length > 0 && this.stage.sees(sphere, this.#share)) return;
    this.#spheres.push(sphere);
    this.look();
  }

  /** Look at all that is expected, and was seen beside it. */
  look(): void {
    if (this.#spheres.length === 0) return;
    this.#moved = false;
    // With room for what plays it, at the foot of the picture.
    const seen = this.#spheres.map(({ center, radius }) => new Sphere(center, 1.15 * radius));
    this.stage.lookAtAll(seen, new Vector3(0.5, 0.35, 1), this.#share);
  }

  /** How much of the width there is for the mesh. */
  get #share(): number {
    return this.#layout === "beside" ? 0.5 : 1;
  }

  close(): void {
    for (const mesh of [this.#mesh, this.#original, this.#wires]) mesh.geometry.dispose();
    this.#wires.material.dispose();
    this.stage.close();
  }

  #shade(): void {
    const solid = this.#solid;
    this.#mesh.material = faceted({ paint: PLAIN, colored: this.#coloring !== "plain", solid });
    this.#original.material = faceted({ paint: ORIGINAL, colored: false, solid });
  }

  #render(): void {
    const { width } = this.stage;
    if (this.#layout !== "beside") {
      this.#view(0, width, this.#layout !== "original", this.#layout === "original");
      return;
    }
    const half = Math.floor(width / 2);
    this.#view(0, half - 1, false, true);
    this.#view(half, width - half, true, false);
  }

  /** Draw into a part of the canvas. */
  #view(left: number, width: number, decoded: boolean, original: boolean): void {
    const { renderer, camera, scene, height } = this.stage;
    this.#mesh.visible = decoded;
    this.#original.visible = original;
    this.#wires.visible = this.#layout === "overlaid";
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    renderer.setScissorTest(true);
    renderer.setScissor(left, 0, width, height);
    renderer.setViewport(left, 0, width, height);
    renderer.render(scene, camera);
  }
}

/** Colors that neighbouring numbers do not share: the hue turns by the golden ratio. */
function clusterColor(label: number): Color {
  return new Color().setHSL((label * 0.618034 + 0.08) % 1, 0.55, 0.6);
}
