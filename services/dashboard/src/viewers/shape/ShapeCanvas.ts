import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  Group,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  Raycaster,
  SphereGeometry,
  Spherical,
  Vector2,
  Vector3,
} from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { Stage } from "../stage/Stage";
import type { Graph } from "./graph";
import type { ShapeModel } from "./model";
import { cornerNormals, type Surface } from "./surface";
import type { LinkedView, Turn, ViewLink } from "./ViewLink";

const [MARGIN, NEAREST, FARTHEST] = [1.06, 1.2, 20];

/**
 * Each point of a face takes the color of its nearest corner, so that borders between parts run between vertices instead
 * of along the edges of whole faces.
 */
function colorByCorner(shader: { vertexShader: string; fragmentShader: string }): void {
  const passed = ["corner", "colorA", "colorB", "colorC"].map((name) => `varying vec3 v_${name};`).join("\n");
  shader.vertexShader = `attribute vec3 corner, colorA, colorB, colorC;\n${passed}\n${shader.vertexShader}`.replace(
    "#include <begin_vertex>",
    `#include <begin_vertex>
    v_corner = corner; v_colorA = colorA; v_colorB = colorB; v_colorC = colorC;`,
  );
  shader.fragmentShader = `${passed}\n${shader.fragmentShader}`.replace(
    "#include <color_fragment>",
    `diffuseColor.rgb *= v_corner.x >= max(v_corner.y, v_corner.z) ? v_colorA
      : v_corner.y >= v_corner.z ? v_colorB : v_colorC;`,
  );
}

/** Of the graph: to the level below, and to neighbours. They serve all canvases, and stay, as their program does. */
const PARENTS = ink("#ffffff", 1.6, 0.75);
const NEIGHBOURS = ink("#f4c56a", 2.2, 0.85);

function ink(color: string, linewidth: number, opacity: number): LineMaterial {
  return new LineMaterial({ color, linewidth, transparent: true, opacity, depthTest: false });
}

/** Called for each point of a face that the pointer paints. */
export type OnPaint = (face: number, at: [number, number, number]) => void;

/** A shape as it stands, a color to each corner of its faces. Draws only when something has changed. */
export class ShapeCanvas implements LinkedView {
  readonly stage: Stage;
  readonly #mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
  /** The colors of a face's first, second and third corner, told to each of them. */
  readonly #colors: readonly BufferAttribute[];
  readonly #graph = new Group();
  readonly #link: ViewLink | null;
  readonly #surface: Surface;
  readonly #front: Vector3;
  readonly #home = new Spherical();
  #following = false;
  #paint: OnPaint | null = null;

  /** Begins where the picture of the shape was taken from. */
  constructor(
    parent: HTMLElement,
    { surface, towards }: Pick<ShapeModel, "surface" | "towards">,
    link: ViewLink | null,
    onLost: () => void,
  ) {
    this.#surface = surface;
    this.#front = new Vector3(...towards).normalize();
    this.stage = new Stage(parent, { light: [-0.5, 0.8, 1], onHome: () => this.look(), onLost });
    const { camera, controls, scene } = this.stage;
    [camera.near, camera.far] = [0.05, 50];
    camera.updateProjectionMatrix();
    const corners = surface.faces.length;
    const positions = new Float32Array(3 * corners);
    for (let i = 0; i < corners; i += 1) {
      const v = surface.faces[i] as number;
      for (let k = 0; k < 3; k += 1) positions[3 * i + k] = surface.positions[3 * v + k] as number;
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(cornerNormals(surface), 3));
    this.#colors = (["colorA", "colorB", "colorC"] as const).map((name) => {
      const attribute = new BufferAttribute(new Float32Array(3 * corners).fill(0.5), 3);
      geometry.setAttribute(name, attribute);
      return attribute;
    });
    const weights = Float32Array.from({ length: 3 * corners }, (_, i) => ((i % 9) % 4 === 0 ? 1 : 0));
    geometry.setAttribute("corner", new BufferAttribute(weights, 3));
    const material = new MeshStandardMaterial({ roughness: 0.6, metalness: 0, side: DoubleSide });
    material.onBeforeCompile = colorByCorner;
    this.#mesh = new Mesh(geometry, material);
    scene.add(this.#mesh, this.#graph);
    controls.enablePan = false;
    [controls.minDistance, controls.maxDistance] = [NEAREST, FARTHEST];
    controls.addEventListener("change", this.#moved);
    parent.addEventListener("pointerdown", this.#down, { capture: true });
    this.#link = link;
    this.begin(null);
    link?.join(this);
  }

  get turn(): Turn {
    const now = new Spherical().setFromVector3(this.stage.camera.position);
    return {
      around: now.theta - this.#home.theta,
      down: now.phi - this.#home.phi,
      away: now.radius / this.#home.radius,
    };
  }

  follow({ around, down, away }: Turn): void {
    this.#following = true;
    this.#place(new Spherical(this.#home.radius * away, this.#home.phi + down, this.#home.theta + around));
    this.#following = false;
  }

  /** Look at all of the shape. */
  look(): void {
    this.#place(this.#home);
  }

  /** Begin where some faces show most; null: at the side that the picture shows. */
  begin(faces: Int32Array | null): void {
    const towards = (faces && this.#towards(faces)) ?? this.#front;
    this.#home.setFromVector3(towards.clone().multiplyScalar(this.#distance(towards)));
    this.#home.phi = Math.min(Math.max(this.#home.phi, 0.3), Math.PI - 0.3);
    this.look();
  }

  /** Red, green and blue of each corner of each face, in [0, 1] as on the screen. */
  color(corners: Float32Array): void {
    const color = new Color();
    this.#colors.forEach((attribute, corner) => {
      for (let f = 0; f < corners.length / 9; f += 1) {
        const [red = 0, green = 0, blue = 0] = corners.subarray(9 * f + 3 * corner, 9 * f + 3 * corner + 3);
        color.setRGB(red, green, blue, "srgb");
        for (let k = 0; k < 3; k += 1) color.toArray(attribute.array, 9 * f + 3 * k);
      }
      attribute.needsUpdate = true;
    });
    this.stage.draw();
  }

  /** Draw a graph over the surface, which becomes glassy; null takes it away. */
  drawGraph(graph: Graph | null): void {
    this.#clearGraph();
    const { material } = this.#mesh;
    material.transparent = graph !== null;
    material.opacity = graph ? 0.42 : 1;
    material.depthWrite = graph === null;
    material.needsUpdate = true;
    if (graph) {
      const at = (i: number) => graph.nodes[i]?.at ?? [0, 0, 0];
      const lines = (pairs: readonly [number, number][], material: LineMaterial) => {
        if (pairs.length === 0) return;
        const geometry = new LineSegmentsGeometry();
        geometry.setPositions(pairs.flatMap(([one, other]) => [...at(one), ...at(other)]));
        const segments = new LineSegments2(geometry, material);
        segments.renderOrder = 1;
        this.#graph.add(segments);
      };
      lines(graph.parents, PARENTS);
      lines(graph.neighbours, NEIGHBOURS);
      const ball = new SphereGeometry(1, 20, 14);
      graph.nodes.forEach((node, order) => {
        const color = new Color().setRGB(...node.color, "srgb");
        const mesh = new Mesh(ball, new MeshBasicMaterial({ color, depthTest: false, transparent: true }));
        mesh.position.set(...node.at);
        mesh.scale.setScalar(node.size);
        mesh.renderOrder = 2 + order; // the level above lies behind
        this.#graph.add(mesh);
      });
    }
    this.stage.draw();
  }

  /** While set, a drag that begins on the shape paints; one beside it turns, as always. */
  paintWith(paint: OnPaint | null): void {
    this.#paint = paint;
    this.stage.canvas.style.cursor = paint ? "crosshair" : "";
  }

  close(): void {
    this.#link?.leave(this);
    this.stage.canvas.parentElement?.removeEventListener("pointerdown", this.#down, { capture: true });
    this.#clearGraph();
    this.#mesh.geometry.dispose();
    this.#mesh.material.dispose();
    this.stage.close();
  }

  #moved = () => {
    if (!this.#following) this.#link?.moved(this);
  };

  #place(at: Spherical): void {
    const radius = Math.min(Math.max(at.radius, NEAREST), FARTHEST);
    const phi = Math.min(Math.max(at.phi, 0.05), Math.PI - 0.05);
    this.stage.camera.position.setFromSpherical(new Spherical(radius, phi, at.theta));
    this.stage.controls.update();
    this.#moved();
    this.stage.draw();
  }

  /** Where some faces look to, on the whole; where they look everywhere, the side on which they lie. */
  #towards(faces: Int32Array): Vector3 | null {
    const { areas, middles } = this.#surface;
    const normals = this.#mesh.geometry.getAttribute("normal");
    const [facing, place, one] = [new Vector3(), new Vector3(), new Vector3()];
    let area = 0;
    for (const f of faces) {
      const weight = areas[f] as number;
      area += weight;
      facing.addScaledVector(one.fromBufferAttribute(normals, 3 * f), weight);
      place.addScaledVector(one.fromArray(middles, 3 * f), weight);
    }
    if (area === 0) return null;
    const towards = facing.length() > 0.35 * area ? facing : place;
    return towards.length() > 0.02 * area ? towards.normalize() : null;
  }

  /** How far away all of the shape is seen from a side, and fills the view. */
  #distance(towards: Vector3): number {
    const up = Math.tan((this.stage.camera.fov * Math.PI) / 360);
    const right = new Vector3(0, 1, 0).cross(towards);
    if (right.lengthSq() < 1e-6) right.set(1, 0, 0);
    right.normalize();
    const above = towards.clone().cross(right);
    const { positions } = this.#surface;
    const point = new Vector3();
    let distance = NEAREST;
    for (let i = 0; i < positions.length; i += 3) {
      point.fromArray(positions, i);
      const beside = Math.abs(point.dot(right)) / this.stage.camera.aspect;
      distance = Math.max(distance, point.dot(towards) + (MARGIN * Math.max(beside, Math.abs(point.dot(above)))) / up);
    }
    return Math.min(distance, FARTHEST);
  }

  #clearGraph(): void {
    for (const child of [...this.#graph.children]) {
      this.#graph.remove(child);
      if (!(child instanceof Mesh)) continue;
      (child.geometry as BufferGeometry).dispose();
      if (child.material instanceof MeshBasicMaterial) child.material.dispose();
    }
  }

  #hit(event: PointerEvent): { face: number; at: [number, number, number] } | null {
    const box = this.stage.canvas.getBoundingClientRect();
    const place = new Vector2(
      ((event.clientX - box.left) / box.width) * 2 - 1,
      1 - ((event.clientY - box.top) / box.height) * 2,
    );
    const caster = new Raycaster();
    caster.setFromCamera(place, this.stage.camera);
    const [hit] = caster.intersectObject(this.#mesh);
    return hit?.faceIndex === undefined || hit.faceIndex === null
      ? null
      : { face: hit.faceIndex, at: [hit.point.x, hit.point.y, hit.point.z] };
  }

  #down = (event: PointerEvent) => {
    if (!this.#paint || event.button !== 0 || !event.isPrimary) return;
    const first = this.#hit(event);
    if (!first) return;
    event.stopPropagation(); // the controls would turn the shape
    event.preventDefault();
    this.stage.canvas.focus();
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.#paint(first.face, first.at);
    const move = (next: PointerEvent) => {
      for (const step of next.getCoalescedEvents?.().slice(-4) ?? [next]) {
        const hit = this.#hit(step);
        if (hit) this.#paint?.(hit.face, hit.at);
      }
    };
    const up = () => {
      this.stage.canvas.removeEventListener("pointermove", move);
      this.stage.canvas.removeEventListener("pointerup", up);
      this.stage.canvas.removeEventListener("pointercancel", up);
    };
    this.stage.canvas.addEventListener("pointermove", move);
    this.stage.canvas.addEventListener("pointerup", up);
    this.stage.canvas.addEventListener("pointercancel", up);
  };
}
