/** What an element that is a good guest on a page does not do. */

import assert from "node:assert/strict";

const SILENCE_MILLISECONDS = 700;

/** The page's only worker, with its animation frames counted from now on. */
async function countedWorker(page) {
  const [worker] = page.workers();
  await worker.evaluate(() => {
    const request = globalThis.requestAnimationFrame.bind(globalThis);
    globalThis.frames = 0;
    globalThis.requestAnimationFrame = (callback) => {
      globalThis.frames += 1;
      return request(callback);
    };
  });
  return worker;
}

/** Waits for animation frames, however long they take on a busy machine. */
async function someFrames(worker, pause) {
  while ((await framesWithin(worker, pause)) === 0);
}

/** Waits until no frame is asked for any more: what was under way may end. An element that goes on runs into the case's limit. */
async function silence(worker, pause) {
  while ((await framesWithin(worker, pause)) > 0);
}

async function framesWithin(worker, pause) {
  await worker.evaluate(() => {
    globalThis.frames = 0;
  });
  await pause(SILENCE_MILLISECONDS);
  return await worker.evaluate(() => globalThis.frames);
}

/** Devices and bytes of the worker's wasm module. */
function memory(worker) {
  return worker.evaluate(async () => {
    const { default: initialise } = await import("/web/pkg/crease.js");
    const { memory } = await initialise();
    return memory.buffer.byteLength;
  });
}

export default [
  {
    name: "manners: paused, off screen or hidden, it asks for no animation frame; moving, it does",
    run: async ({ mount, withAvatar, page, pause }) => {
      await mount({ loop: true, fps: 20 });
      const worker = await countedWorker(page);
      await silence(worker, pause);
      await withAvatar((avatar) => void avatar.play());
      await someFrames(worker, pause);
      await withAvatar((avatar) => {
        avatar.style.marginTop = "5000px";
      });
      await silence(worker, pause);
      await withAvatar((avatar) => {
        avatar.style.marginTop = "0";
      });
      await someFrames(worker, pause);
      await withAvatar((avatar) => {
        avatar.style.display = "none";
      });
      await silence(worker, pause);
      await withAvatar((avatar) => {
        avatar.style.display = "block";
        Object.defineProperty(document, "visibilityState", { get: () => "hidden", configurable: true });
        document.dispatchEvent(new Event("visibilitychange"));
      });
      await silence(worker, pause);
    },
  },
  {
    name: "manners: lazy and off screen it fetches nothing, and starts no worker",
    run: async ({ open, page, server, pause }) => {
      await open();
      server.requests.length = 0;
      await page.evaluate(() => {
        const above = document.createElement("div");
        above.style.height = "5000px";
        document.body.append(above, make({ loading: "lazy" }));
      });
      await pause(SILENCE_MILLISECONDS);
      assert.deepEqual([server.requests, page.workers().length], [[], 0]);
      await page.evaluate(async () => {
        scrollTo(0, 5000);
        await document.querySelector("crease-avatar").ready;
      });
      assert.ok(server.requests.includes("/tests/fixtures/tiny.glb"));
    },
  },
  {
    name: "manners: taken away it ends its worker; put back it plays on",
    run: async ({ mount, withAvatar, page, pause }) => {
      await mount({ loop: true, fps: 20 });
      const removed = await page.evaluateHandle(async () => {
        const avatar = document.querySelector("crease-avatar");
        const done = next(avatar, "seeked");
        avatar.currentTime = 0.1;
        await done;
        avatar.remove();
        return avatar;
      });
      while (page.workers().length > 0) await pause(50);
      const time = await removed.evaluate(async (avatar) => {
        const loaded = next(avatar, "load");
        document.body.append(avatar);
        await loaded;
        return avatar.currentTime;
      });
      assert.equal(time, 0.1);
      assert.equal(await withAvatar((avatar) => avatar.shadowRoot.querySelectorAll("canvas").length), 1);
    },
  },
  {
    name: "manners: moved within the page it does not load again",
    run: async ({ mount, withAvatar, server, pause }) => {
      await mount();
      server.requests.length = 0;
      const told = await withAvatar(async (avatar) => {
        const heard = listen(avatar, ["load", "progress", "error"]);
        const canvas = avatar.shadowRoot.querySelector("canvas");
        const elsewhere = document.createElement("section");
        document.body.append(elsewhere);
        elsewhere.append(avatar);
        const done = next(avatar, "seeked");
        avatar.currentTime = 0.2;
        await done;
        return { heard, same: avatar.shadowRoot.querySelector("canvas") === canvas };
      });
      await pause(200);
      assert.deepEqual([told, server.requests], [{ heard: [], same: true }, []]);
    },
  },
  {
    name: "manners: another address cancels the load of the one before",
    run: async ({ mount, withAvatar, server, pause }) => {
      await mount({ src: "/bad/never.glb" }, { ready: false });
      for (let tries = 0; server.held.size === 0 && tries < 200; tries += 1) await pause(50);
      assert.equal(server.held.size, 1, "the first load is under way");
      const errors = await withAvatar(async (avatar) => {
        const heard = listen(avatar, ["error"]);
        avatar.src = TINY;
        await avatar.ready;
        return heard;
      });
      await pause(300);
      assert.deepEqual([errors, server.held.size], [[], 0]);
    },
  },
  {
    name: "manners: eight elements share one worker, one wasm module and one device",
    run: async ({ open, page, server }) => {
      await open();
      server.requests.length = 0;
      await page.evaluate(async () => {
        const avatars = Array.from({ length: 8 }, () =>
          make({ style: "inline-size: 80px; block-size: 80px; float: left" }),
        );
        document.body.append(...avatars);
        await Promise.all(avatars.map((avatar) => avatar.ready));
      });
      assert.equal(page.workers().length, 1);
      assert.equal(server.requests.filter((path) => path.endsWith(".wasm")).length, 1);
      const devices = await page.workers()[0].evaluate(async () => {
        const { deviceCount } = await import("/web/pkg/crease.js");
        return deviceCount();
      });
      assert.equal(devices, 1);
    },
  },
  {
    name: "manners: a device that is lost comes back for all who share it",
    allows: [/graphics device was lost.*Starting again/u, /device was lost|destroyed/iu],
    run: async ({ open, page }) => {
      await open();
      const backends = await page.evaluate(async () => {
        const avatars = [make(), make()];
        document.body.append(...avatars);
        await Promise.all(avatars.map((avatar) => avatar.ready));
        const back = avatars.map((avatar) => next(avatar, "backendchange"));
        avatars[0].dispatchEvent(new CustomEvent("crease-lose-device"));
        await Promise.all(back);
        const drawn = avatars.map((avatar) => next(avatar, "seeked"));
        for (const avatar of avatars) avatar.currentTime = 0.2;
        await Promise.all(drawn);
        return avatars.map((avatar) => avatar.currentBackend);
      });
      assert.deepEqual(backends, ["webgpu+cpu", "webgpu+cpu"]);
    },
  },
  {
    name: "manners: under a strict policy it plays",
    run: async ({ mount, withAvatar }) => {
      await mount({ poster: "/tests/goldens/base.png" }, { query: "?strict" });
      assert.equal(await withAvatar((avatar) => avatar.loaded), true);
    },
  },
  {
    name: "manners: in a Chromium without WebGPU it draws with WebGL2",
    run: async ({ server, pageWithoutWebGpu }) => {
      const page = await pageWithoutWebGpu();
      await page.goto(`${server.origin}/blank.html`);
      const found = await page.evaluate(async () => {
        window.put({ backend: null });
        const avatar = document.querySelector("crease-avatar");
        await avatar.ready;
        return { adapter: (await navigator.gpu?.requestAdapter()) ?? null, backend: avatar.currentBackend };
      });
      await page.close();
      assert.deepEqual(found, { adapter: null, backend: "webgl2+cpu" });
    },
  },
  {
    name: "manners: loaded from another origin it works in a worker all the same",
    run: async ({ page, server }) => {
      await page.goto(`${server.origin}/case.css`);
      const thread = await page.evaluate(async (element) => {
        await import(element);
        window.put({});
        const avatar = document.querySelector("crease-avatar");
        await avatar.ready;
        return avatar.statistics.thread;
      }, `${server.otherOrigin}/shared/web/dist/public/crease-avatar.js`);
      assert.equal(thread, "worker");
    },
  },
  {
    name: "manners: with another size the picture is cut, not stretched, and follows",
    run: async ({ mount, withAvatar }) => {
      await mount();
      const told = await withAvatar(async (avatar) => {
        const canvas = avatar.shadowRoot.querySelector("canvas");
        const fit = getComputedStyle(canvas).objectFit;
        avatar.style.inlineSize = "200px";
        await sleep(50);
        let blob = null;
        let size = [];
        await until(async () => {
          blob = await avatar.toBlob();
          const bitmap = await createImageBitmap(blob);
          size = [bitmap.width, bitmap.height];
          return size[0] === 200;
        });
        return { fit, size };
      });
      assert.deepEqual(told, { fit: "cover", size: [200, 320] });
    },
  },
  {
    name: "manners: fifty times put in and taken out, memory does not grow",
    run: async ({ mount, page }) => {
      await mount();
      const cycle = (count) =>
        page.evaluate(async (times) => {
          const keeper = document.querySelector("crease-avatar");
          for (let i = 0; i < times; i += 1) {
            const avatar = make();
            document.body.append(avatar);
            await avatar.ready;
            avatar.remove();
            // The worker obeys in order: it has let go of the one before when it answers for another.
            await sleep(0);
            await keeper.toBlob({ width: 16, height: 16 });
          }
          return keeper.isConnected;
        }, count);
      const [worker] = page.workers();
      await cycle(5);
      const before = await memory(worker);
      await cycle(50);
      const after = await memory(worker);
      assert.equal(page.workers().length, 1);
      const devices = await worker.evaluate(async () => (await import("/web/pkg/crease.js")).deviceCount());
      assert.equal(devices, 1);
      // One page of wasm memory is 64 KiB; the fixture's own data is many of them.
      assert.ok(after - before <= 1 << 20, `${before} bytes before, ${after} after`);
    },
  },
];
