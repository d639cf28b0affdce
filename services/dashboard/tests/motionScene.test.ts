import { readFileSync } from "node:fs";
import { AnimationMixer, Mesh, Vector3 } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { expect, it } from "vitest";
import { Motion } from "@/features/motion/smc/motion";

const read = (name: string) => new Uint8Array(readFileSync(new URL(`golden/${name}`, import.meta.url)));

it("an exported scene is loaded by three, and moves as the motion does", async () => {
  const motion = new Motion(read("trajectory-1.1.smc"));
  const { vertices, frames, fps } = motion.header;
  const scene = await new GLTFLoader().parseAsync(read("trajectory-1.1.glb").buffer, "");
  const mesh = scene.scene.getObjectByProperty("type", "Mesh");
  if (!(mesh instanceof Mesh)) throw new Error("there is no mesh in the scene");
  const { geometry } = mesh as Mesh;
  expect(geometry.getAttribute("position").count).toBe(vertices);
  expect([...(geometry.getIndex()?.array ?? [])]).toEqual([...motion.faces]);
  const [clip] = scene.animations;
  if (!clip) throw new Error("there is no animation in the scene");
  expect(clip.duration).toBeCloseTo((frames - 1) / fps);
  const mixer = new AnimationMixer(scene.scene);
  mixer.clipAction(clip).play();
  const place = new Vector3();
  for (const frame of [0, 1, 7, frames - 2]) {
    mixer.setTime(frame / fps);
    const expected = motion.frame(frame);
    for (let v = 0; v < vertices; v += 1) {
      mesh.getVertexPosition(v, place);
      for (const [axis, value] of place.toArray().entries()) expect(value).toBeCloseTo(expected[3 * v + axis] ?? 0, 4);
    }
  }
});
