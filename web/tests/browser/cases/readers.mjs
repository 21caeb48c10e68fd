/** Files that we write, in a reader that is not ours: three.js. */

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const ROOT = new URL("../../../../", import.meta.url);
const AVATARS = [
  "tests/fixtures/tiny.glb",
  "tests/fixtures/tiny_plain.glb",
  "web/assets/shirt-dancer.glb",
  "web/assets/tee-turner.glb",
];

/** What `crease animate` writes: trainer/tests/animate.rs makes the same. */
const MOVING = "tests/fixtures/tiny_moving.glb";

/** What the JSON chunk of a GLB says of its one figure. */
async function said(file) {
  const bytes = await readFile(new URL(file, ROOT));
  const json = JSON.parse(bytes.toString("utf8", 20, 20 + bytes.readUInt32LE(12)));
  const [primitive] = json.meshes[0].primitives;
  return {
    vertices: json.accessors[primitive.attributes.POSITION].count,
    corners: json.accessors[primitive.indices].count,
    bones: json.skins[0].joints.length,
    isTextured: (json.images ?? []).length > 0,
  };
}

/** three.js and its glTF loader as one script that a page can run; bundled once. */
let threeScript;

/** Gives the page three.js. */
async function addThree(page) {
  threeScript ??= bundle();
  await page.addScriptTag({ content: await threeScript });
}

async function bundle() {
  const contents = `export { GLTFLoader } from "three/addons/loaders/GLTFLoader.js"; export { AnimationMixer, Box3 } from "three";`;
  const resolveDir = fileURLToPath(new URL("web", ROOT));
  const { outputFiles } = await build({
    stdin: { contents, resolveDir },
    bundle: true,
    format: "iife",
    globalName: "THREE",
    write: false,
  });
  return outputFiles[0].text;
}

/** Runs in the page: reads a file, and tells what three.js made of it. */
async function readWithThree(bytes) {
  const { GLTFLoader, Box3 } = window.THREE;
  const { scene } = await new GLTFLoader().parseAsync(bytes, "");
  const meshes = [];
  scene.traverse((object) => {
    if (object.isMesh) meshes.push(object);
  });
  scene.updateMatrixWorld(true);
  const [mesh] = meshes;
  const { position, normal } = mesh.geometry.attributes;
  const lengths = Array.from({ length: normal.count }, (_, k) =>
    Math.hypot(normal.getX(k), normal.getY(k), normal.getZ(k)),
  );
  const box = () => new Box3().setFromObject(scene, true);
  const [rest, map] = [box(), mesh.material.map];
  let posed = null;
  if (mesh.isSkinnedMesh) {
    // The root turns the figure over.
    mesh.skeleton.bones[0].rotation.set(0, 0, Math.PI / 2);
    scene.updateMatrixWorld(true);
    mesh.computeBoundingBox();
    posed = box();
  }
  return {
    meshes: meshes.length,
    vertices: position.count,
    corners: mesh.geometry.index.count,
    bones: mesh.skeleton?.bones.length ?? 0,
    isTextured: (map?.image.width ?? 0) > 0,
    height: rest.max.y - rest.min.y,
    posedWidth: posed && posed.max.x - posed.min.x,
    normalsFrom: Math.min(...lengths),
    normalsTo: Math.max(...lengths),
  };
}

/** Runs in the page: plays a file's animation, and tells where its root and its left shoulder are at the times asked for. */
async function playWithThree(bytes, times) {
  const { GLTFLoader, AnimationMixer } = window.THREE;
  const { scene, animations } = await new GLTFLoader().parseAsync(bytes, "");
  let mesh;
  scene.traverse((object) => {
    if (object.isSkinnedMesh) mesh = object;
  });
  const mixer = new AnimationMixer(scene);
  mixer.clipAction(animations[0]).play();
  const moments = times.map((time) => {
    mixer.setTime(time);
    const [root, shoulder] = [mesh.skeleton.bones[0], mesh.skeleton.bones[16]];
    return { x: root.position.x, turn: root.quaternion.toArray(), shoulder: shoulder.quaternion.toArray() };
  });
  const { map, normalMap } = mesh.material;
  return {
    clips: animations.length,
    duration: animations[0].duration,
    hasTangents: "tangent" in mesh.geometry.attributes,
    pictures: [map, normalMap].map((picture) => (picture?.image.width ?? 0) > 0),
    moments,
  };
}

function requireFigure(found, expected) {
  const { meshes, vertices, corners, bones, isTextured, ...shape } = found;
  assert.deepEqual({ meshes, vertices, corners, bones, isTextured }, { meshes: 1, ...expected });
  assert.ok(shape.height > 1 && shape.height < 2.2, `the figure is ${shape.height} m high`);
  assert.ok(
    shape.normalsFrom > 0.98 && shape.normalsTo < 1.02,
    `normals from ${shape.normalsFrom} to ${shape.normalsTo}`,
  );
}

export default [
  ...AVATARS.map((file) => ({
    name: `readers: three.js sees the skinned figure of ${file}`,
    run: async ({ page, open }) => {
      await open();
      await addThree(page);
      const found = await page.evaluate(
        `fetch(${JSON.stringify(`/${file}`)}).then((answer) => answer.arrayBuffer()).then(${readWithThree})`,
      );
      requireFigure(found, await said(file));
      // Lying, it is as wide as it was high.
      assert.ok(Math.abs(found.posedWidth - found.height) < 0.01, `${found.posedWidth} for ${found.height}`);
    },
  })),
  {
    name: "readers: three.js plays an animated GLB",
    run: async ({ page, open }) => {
      await open();
      await addThree(page);
      const { moments, ...found } = await page.evaluate(
        `fetch("/${MOVING}").then((answer) => answer.arrayBuffer()).then((bytes) => (${playWithThree})(bytes, [0, 0.05]))`,
      );
      found.duration = Math.round(1000 * found.duration);
      assert.deepEqual(found, { clips: 1, duration: 100, hasTangents: true, pictures: [true, true] });
      const near = (values, expected) => values.every((value, k) => Math.abs(value - expected[k]) < 1e-4);
      const [begin, middle] = moments;
      assert.ok(near(begin.turn, [0, 0, 0, 1]), `${begin.turn}`);
      // Half-way between the second frame and the third: 2.25 rad about y, and the arm sunk by 0.45 rad.
      assert.ok(near([middle.x - begin.x], [0.15]), `${middle.x} after ${begin.x}`);
      assert.ok(near(middle.turn, [0, Math.sin(1.125), 0, Math.cos(1.125)]), `${middle.turn}`);
      assert.ok(near(middle.shoulder, [0, 0, -Math.sin(0.225), Math.cos(0.225)]), `${middle.shoulder}`);
    },
  },
  {
    name: "readers: three.js sees the mesh that the element exports",
    run: async ({ page, mount }) => {
      await mount({ src: "/tests/fixtures/tiny_plain.glb", motion: null });
      await addThree(page);
      const found = await page.evaluate(
        `document.querySelector("crease-avatar").exportMesh().then((blob) => blob.arrayBuffer()).then(${readWithThree})`,
      );
      const { vertices, corners } = found;
      assert.ok(vertices > 1000 && corners % 3 === 0);
      requireFigure(found, { vertices, corners, bones: 0, isTextured: true });
    },
  },
  {
    name: "readers: three.js refuses a file that is no GLB",
    run: async ({ page, open }) => {
      await open();
      await addThree(page);
      const refused = page.evaluate(
        `fetch("/bad/noise.glb").then((answer) => answer.arrayBuffer()).then(${readWithThree})`,
      );
      await assert.rejects(refused);
    },
  },
];
