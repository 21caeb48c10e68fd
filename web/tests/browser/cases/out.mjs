/** What comes out: pictures, meshes, films, exact frames; and what other avatars lend. */

import assert from "node:assert/strict";
import { validateBytes } from "gltf-validator";

/** A blob of the page as bytes here. */
async function bytesOf(withAvatar, make, argument) {
  const numbers = await withAvatar(
    {
      toString: () =>
        `async (avatar, argument) => Array.from(new Uint8Array(await (await (${make})(avatar, argument)).arrayBuffer()))`,
    },
    argument,
  );
  return Buffer.from(numbers);
}

const same = (a, b) => Buffer.compare(a, b) === 0;

export default [
  {
    name: "out: a picture is of the type and size that were asked for",
    run: async ({ mount, withAvatar }) => {
      await mount();
      const told = await withAvatar(async (avatar) => {
        const facts = async (blob) => {
          const { width, height } = await createImageBitmap(blob);
          return [blob.type, width, height];
        };
        const address = await avatar.toDataURL("image/jpeg", 0.5);
        return [
          await facts(await avatar.toBlob()),
          await facts(await avatar.toBlob({ type: "image/webp", width: 64, height: 96 })),
          address.slice(0, 23),
          await facts(await avatar.toBlob()),
        ];
      });
      assert.deepEqual(told, [
        ["image/png", 320, 320],
        ["image/webp", 64, 96],
        "data:image/jpeg;base64,",
        ["image/png", 320, 320],
      ]);
    },
  },
  ...["webgpu+cpu", "webgl2+cpu"].map((backend) => ({
    name: `out: the frame of a moment is the same whatever was before (${backend})`,
    run: async ({ mount, withAvatar }) => {
      await mount({ backend, loop: true, fps: 10, "camera-controls": true });
      const frame = (seconds) =>
        bytesOf(
          withAvatar,
          async (avatar, time) => {
            await avatar.renderFrame(time);
            return await avatar.toBlob();
          },
          seconds,
        );
      const first = await frame(0.1);
      const other = await frame(0);
      await withAvatar(async (avatar) => {
        void avatar.play();
        await sleep(700);
      });
      assert.ok(same(await frame(0.1), first), "the same moment is another picture");
      assert.ok(!same(other, first), "another moment is the same picture");
      assert.equal(await withAvatar((avatar) => avatar.paused), true);
    },
  })),
  {
    name: "out: a mesh as glb is valid, with its texture; obj and ply have as many vertices",
    run: async ({ mount, withAvatar }) => {
      await mount({ src: "/tests/fixtures/tiny_plain.glb" });
      const mesh = (format) => bytesOf(withAvatar, (avatar, format) => avatar.exportMesh({ format }), format);
      const report = await validateBytes(new Uint8Array(await mesh("glb")));
      assert.deepEqual([report.issues.numErrors, report.issues.numWarnings], [0, 0], JSON.stringify(report.issues));
      assert.equal(report.info.hasTextures, true);
      const count = report.info.totalVertexCount;
      const obj = (await mesh("obj")).toString();
      assert.equal(obj.match(/^v -?\d\S* \S+ \S+ [01]\.\d+ /gmu)?.length, count);
      assert.equal(obj.match(/^vt /gmu)?.length, count);
      const ply = (await mesh("ply")).toString("latin1", 0, 400);
      assert.match(ply, new RegExp(`element vertex ${count}\n`, "u"));
      assert.match(ply, /property uchar red/u);
      const refused = await withAvatar((avatar) =>
        avatar.exportMesh({ format: "fbx" }).catch((error) => error.message),
      );
      assert.match(refused, /format: expected glb, obj or ply, found fbx/u);
    },
  },
  {
    name: "out: a film has every frame at its time, and the motion goes on from where it was",
    run: async ({ mount, withAvatar, page }) => {
      await mount({ fps: 4, loop: true });
      const told = await withAvatar(async (avatar) => {
        const done = next(avatar, "seeked");
        avatar.currentTime = 0.05;
        await done;
        const heard = listen(avatar, ["timeupdate", "pause", "ended", "seeking"]);
        const blob = await avatar.record({ seconds: 0.5, fps: 20, width: 160, height: 120 });
        const video = document.createElement("video");
        video.muted = true;
        video.src = URL.createObjectURL(blob);
        await new Promise((resolve, reject) => {
          video.onloadeddata = resolve;
          video.onerror = () => reject(new Error(video.error.message));
        });
        const { duration, videoWidth, videoHeight } = video;
        const pixel = async (seconds) => {
          // A frame is on its way to the screen for a while after the seek is done.
          const shown = new Promise((resolve) => video.requestVideoFrameCallback(resolve));
          const sought = next(video, "seeked");
          video.currentTime = seconds;
          await Promise.all([sought, Promise.race([shown, sleep(3000)])]);
          const context = new OffscreenCanvas(160, 120).getContext("2d", { willReadFrequently: true });
          context.drawImage(video, 0, 0);
          return Array.from(context.getImageData(0, 0, 160, 120).data);
        };
        const [first, last] = [await pixel(0.02), await pixel(0.47)];
        const moved = first.filter((byte, i) => Math.abs(byte - last[i]) > 12).length;
        return { heard, type: blob.type, duration, size: [videoWidth, videoHeight], moved, time: avatar.currentTime };
      });
      assert.deepEqual(told.heard, [], "the page hears of no time but its own");
      assert.equal(told.type, "video/webm");
      assert.ok(Math.abs(told.duration - 0.5) < 0.02, String(told.duration));
      assert.deepEqual([told.size, told.time], [[160, 120], 0.05]);
      assert.ok(told.moved > 50, `${told.moved} bytes moved`);
      assert.equal(page.isClosed(), false);
    },
  },
  {
    name: "out: a live pose takes the motion's place, at once and smoothly, and gives it back",
    run: async ({ mount, withAvatar }) => {
      await mount({ quality: "best", follow: "root" });
      const picture = () => bytesOf(withAvatar, (avatar) => avatar.toBlob());
      const motion = await picture();
      await withAvatar((avatar) => {
        const pose = new Float32Array(72);
        pose[3 * 16 + 2] = 1.2;
        avatar.pose = pose;
      });
      const posed = await picture();
      assert.ok(!same(posed, motion));
      await withAvatar((avatar) => {
        avatar.translation = [0.3, 0.9, 0];
      });
      assert.ok(!same(await picture(), posed));
      const told = await withAvatar(async (avatar) => {
        avatar.translation = null;
        avatar.smoothing = 0.05;
        avatar.pose = new Float32Array(72);
        await sleep(1500);
        const refused = [];
        for (const wrong of [[1, 2], new Array(72).fill(Number.NaN)]) {
          try {
            avatar.pose = wrong;
          } catch (error) {
            refused.push(error.message);
          }
        }
        return { refused, length: avatar.pose.length };
      });
      assert.deepEqual(told, {
        refused: ["pose: expected 72 finite numbers, found 2", "pose: expected 72 finite numbers, found 72"],
        length: 72,
      });
      const rest = await picture();
      await withAvatar((avatar) => {
        avatar.smoothing = 0;
        avatar.pose = new Float32Array(72);
      });
      assert.ok(same(await picture(), rest), "it has arrived");
      await withAvatar((avatar) => {
        avatar.pose = null;
      });
      assert.ok(same(await picture(), motion), "the motion is back");
    },
  },
  ...["webgpu", "webgl2+cpu"].map((backend) => ({
    name: `out: another avatar's texture and wrinkles are worn, and taken off again (${backend})`,
    run: async ({ mount, withAvatar }) => {
      await mount({ backend, quality: "best", src: "/tests/fixtures/tiny_plain.glb" });
      const picture = () => bytesOf(withAvatar, (avatar) => avatar.toBlob());
      const put = (name, value) =>
        withAvatar(
          (avatar, [name, value]) => {
            if (value === null) avatar.removeAttribute(name);
            else avatar.setAttribute(name, value);
          },
          [name, value],
        );
      const own = await picture();
      await put("detail-from", "/tests/fixtures/tiny.glb");
      const wrinkled = await picture();
      assert.ok(!same(wrinkled, own), "the wrinkles are the own ones");
      await put("detail-from", null);
      assert.ok(same(await picture(), own), "the own wrinkles are not back");
      await put(
        "texture",
        await withAvatar(async () => {
          const canvas = new OffscreenCanvas(8, 8);
          const context = canvas.getContext("2d");
          context.fillStyle = "teal";
          context.fillRect(0, 0, 8, 8);
          return URL.createObjectURL(await canvas.convertToBlob());
        }),
      );
      const dressed = await picture();
      assert.ok(!same(dressed, own), "the texture is the own one");
      await put("texture", "/tests/fixtures/tiny_plain.glb");
      assert.ok(same(await picture(), own), "the texture of the same avatar is another");
      assert.equal(await withAvatar((avatar) => avatar.error), null);
    },
  })),
];
