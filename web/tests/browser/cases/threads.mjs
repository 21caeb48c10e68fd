/** What the element does in a page that is isolated from others: its workers share memory, and its frames. */

import assert from "node:assert/strict";

/** Large enough to be shared out. */
const DANCER = {
  src: "/web/assets/shirt-dancer.glb",
  motion: "/web/assets/motions/dance_a.pkl",
  fps: 60,
  quality: "high",
};

/** A hash of the mesh at a moment of the motion, and how many threads computed it. */
const meshAt = async (avatar, seconds) => {
  await avatar.renderFrame(seconds);
  const bytes = new Uint8Array(await (await avatar.exportMesh({ format: "obj" })).arrayBuffer());
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", bytes));
  return { digest: [...digest].join(" "), length: bytes.length, threads: avatar.statistics.threads };
};

/** The machine of the tests need not have four processors. */
const fourProcessors = (page) =>
  page.addInitScript(() => {
    Object.defineProperty(Navigator.prototype, "hardwareConcurrency", { get: () => 4 });
  });

const untilThreads = async (page, count) => {
  await page.waitForFunction((wanted) => document.querySelector("crease-avatar").statistics.threads === wanted, count);
};

export default [
  {
    name: "threads: an isolated page shares its frames out, and shows the very same figure",
    run: async ({ mount, page, withAvatar, server }) => {
      await mount(DANCER);
      const alone = await withAvatar(meshAt, 0.5);
      assert.equal(alone.threads, 1);
      assert.ok(
        !server.requests.some((path) => /thread\.js|crease_threads/u.test(path)),
        "it loads nothing for threads",
      );
      await fourProcessors(page);
      server.requests.length = 0;
      await mount(DANCER, { query: "?isolated" });
      await untilThreads(page, 3);
      assert.deepEqual(await withAvatar(meshAt, 0.5), { ...alone, threads: 3 });
      assert.ok(!server.requests.includes("/web/pkg/crease_bg.wasm"), "it loads one module");
    },
  },
  {
    name: "threads: every backend draws the same picture from memory that is shared",
    run: async ({ mount, page, withAvatar }) => {
      await fourProcessors(page);
      for (const backend of ["webgpu", "webgpu+cpu", "webgl2+cpu"]) {
        const pictures = [];
        for (const query of ["", "?isolated"]) {
          await mount({ backend }, { query });
          pictures.push(
            await withAvatar(async (avatar) => {
              await avatar.renderFrame(0.3);
              const bytes = new Uint8Array(await (await avatar.toBlob()).arrayBuffer());
              return { backend: avatar.statistics.backend, picture: btoa(String.fromCharCode(...bytes)) };
            }),
          );
        }
        assert.equal(pictures[0].backend, backend);
        assert.deepEqual(pictures[0], pictures[1]);
      }
    },
  },
  {
    name: "threads: they end with the last avatar, and one that comes back has them again",
    run: async ({ mount, page, withAvatar, pause }) => {
      await fourProcessors(page);
      await mount({}, { query: "?isolated" });
      await untilThreads(page, 3);
      assert.equal(page.workers().length, 3);
      await withAvatar((avatar) => avatar.remove());
      while (page.workers().length > 0) await pause(50);
      await page.evaluate(async () => {
        document.body.append(make());
        await document.querySelector("crease-avatar").ready;
      });
      await untilThreads(page, 3);
    },
  },
  {
    name: "threads: where there are two processors a frame has one thread",
    run: async ({ mount, page, withAvatar }) => {
      await page.addInitScript(() => {
        Object.defineProperty(Navigator.prototype, "hardwareConcurrency", { get: () => 2 });
      });
      await mount({}, { query: "?isolated" });
      assert.equal(await withAvatar((avatar) => avatar.statistics.threads), 1);
    },
  },
  {
    name: "threads: without their module there is one, and the reason is told once",
    allows: [
      /404/u,
      /threads: .*crease_threads_bg\.wasm: expected a file, found status 404\. Using one thread instead\./u,
    ],
    run: async ({ mount, page, withAvatar, server }) => {
      const told = [];
      page.on("console", (message) => told.push(message.text()));
      server.instead.set("/web/pkg/crease_threads_bg.wasm", { status: 404 });
      await fourProcessors(page);
      await mount({}, { query: "?isolated" });
      assert.equal(await withAvatar((avatar) => avatar.statistics.threads), 1);
      assert.equal(told.filter((text) => text.includes("Using one thread instead")).length, 1);
    },
  },
  {
    name: "threads: a worker that does not start is done without",
    allows: [/thread\.js|404/u],
    run: async ({ mount, page, withAvatar, server }) => {
      server.instead.set("/web/dist/internal/thread.js", { status: 404 });
      await fourProcessors(page);
      await mount(DANCER, { query: "?isolated" });
      assert.equal((await withAvatar(meshAt, 0.5)).threads, 1);
    },
  },
  {
    name: "threads: one that breaks ends the figure with an error",
    allows: [/./u],
    run: async ({ open, page, server }) => {
      // It says that it takes part, and then breaks where it should.
      server.instead.set("/web/dist/internal/thread.js", {
        change: (bytes) => Buffer.from(bytes.toString().replace("joinThreads();", 'throw new Error("broken");')),
      });
      await fourProcessors(page);
      await open("?isolated");
      const failure = await page.evaluate(async () => {
        put({});
        const avatar = document.querySelector("crease-avatar");
        await next(avatar, "error");
        return { code: avatar.error.code, message: avatar.error.message };
      });
      assert.equal(failure.code, "internal");
      assert.match(failure.message, /broken/u);
    },
  },
];
