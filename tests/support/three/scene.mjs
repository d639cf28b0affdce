// `node scene.mjs THREE SCENE.glb SHOWN.json SECONDS…` lets three.js load a scene, and writes the faces, the number of
// morph targets, and the vertices of the only mesh at some times. THREE is the folder of the package.
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, scene, shown, ...seconds] = process.argv.slice(2);
const load = (...parts) => import(pathToFileURL(join(folder, ...parts)).href);
const { AnimationMixer, Vector3 } = await load("build", "three.module.js");
const { GLTFLoader } = await load("examples", "jsm", "loaders", "GLTFLoader.js");

const bytes = readFileSync(scene);
const data = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
const found = await new GLTFLoader().parseAsync(data, "");
const meshes = [];
found.scene.traverse((item) => {
  if (item.isMesh) meshes.push(item);
});
const [mesh] = meshes;
const mixer = new AnimationMixer(found.scene);
for (const clip of found.animations) mixer.clipAction(clip).play();
const point = new Vector3();
const vertices = seconds.map((second) => {
  mixer.setTime(Number(second));
  found.scene.updateMatrixWorld(true);
  return Array.from({ length: mesh.geometry.attributes.position.count }, (_, index) =>
    mesh.getVertexPosition(index, point).applyMatrix4(mesh.matrixWorld).toArray(),
  );
});
const faces = Array.from(mesh.geometry.index.array);
const targets = mesh.morphTargetInfluences?.length ?? 0;
writeFileSync(shown, JSON.stringify({ meshes: meshes.length, targets, faces, vertices }));
