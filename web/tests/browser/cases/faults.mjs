/** Faults of the machine under the page: a typed error with the fallback shown, or a picture again; never a silent black canvas. */

import assert from "node:assert/strict";

/** Makes the page's worker throw outside of every command, as a bug or a lack of memory does. */
function crash(page) {
  return page.workers()[0].evaluate(() => {
    setTimeout(() => {
      throw new Error("a made fault");
    });
  });
}

/** Leaves the worker's wasm module as a trap does: every frame that is asked of it throws. */
function trap(page) {
  return page.workers()[0].evaluate(async () => {
    const { Viewer } = await import("/web/pkg/crease.js");
    Viewer.prototype.advance = () => {
      throw new WebAssembly.RuntimeError("unreachable");
    };
  });
}

/** What an avatar says of a fault, and whether it plays again once it is asked to. */
function failsAndComesBack({ withAvatar }, address = "PLAIN") {
  return withAvatar(async (avatar, other) => {
    const fallback = document.createElement("p");
    fallback.slot = "fallback";
    fallback.textContent = "No avatar here.";
    avatar.append(fallback);
    const began = performance.now();
    if (!avatar.error) await next(avatar, "error");
    const { code, message } = avatar.error;
    const shown = fallback.checkVisibility();
    const seconds = (performance.now() - began) / 1000;
    const loaded = next(avatar, "load");
    avatar.src = window[other];
    await loaded;
    return { code, message, shown, gone: !fallback.checkVisibility(), error: avatar.error, seconds };
  }, address);
}

const MODULE = "/web/pkg/crease_bg.wasm";
const WORKER = "/web/dist/internal/worker.js";
const STAGE = "/web/dist/internal/stage.js";

/** A page that a cache or a deployment has given other files than it needs, and what comes of it once the right ones are there. */
function mixture(name, instead, expected) {
  return {
    name: `faults: ${name}`,
    // The browser reports what it could not load.
    allows: [/Failed to load resource|ERR_|MIME type/u],
    run: async (tools) => {
      const { server, mount, withAvatar } = tools;
      for (const [path, answer] of Object.entries(instead)) server.instead.set(path, answer);
      await mount({}, { ready: false });
      await withAvatar(async (avatar) => {
        if (!avatar.error) await next(avatar, "error");
      });
      for (const path of Object.keys(instead)) assert.ok(server.requests.includes(path), `${path} was asked for`);
      server.instead.clear();
      const { message, shown, gone, error, code } = await failsAndComesBack(tools);
      assert.deepEqual(
        { code, shown, gone, error },
        { code: expected.code, shown: true, gone: true, error: null },
        message,
      );
      assert.match(message, expected.message);
    },
  };
}

const withText = (from, to) => ({
  change: (bytes) => {
    const text = bytes.toString("latin1");
    assert.match(text, from);
    return Buffer.from(text.replace(from, to), "latin1");
  },
});

export default [
  mixture(
    "a wasm module of another build is told by its name",
    { [MODULE]: withText(/[0-9a-f]{12}$/u, "0123456789ab") },
    { code: "version", message: /crease_bg\.wasm: expected a file of build \S+, found \S+-0123456789ab\. Reload/u },
  ),
  mixture(
    "a wasm module without the name of its build is one of another",
    { [MODULE]: withText(/crease-build/u, "crease-guild") },
    { code: "version", message: /crease_bg\.wasm: expected a file of build \S+, found one without a name/u },
  ),
  mixture(
    "a worker of another build is told by its name",
    { [WORKER]: withText(/build: BUILD/u, 'build: "0.0.1-old"') },
    { code: "version", message: /worker\.js: expected a file of build \S+, found 0\.0\.1-old\. Reload/u },
  ),
  mixture(
    "a worker from before builds had names is one of another",
    { [WORKER]: withText(/build: BUILD,/u, "") },
    { code: "version", message: /worker\.js: expected a file of build \S+, found one without a name/u },
  ),
  mixture(
    "a wasm module that is gone",
    { [MODULE]: { status: 404 } },
    { code: "http", message: /crease_bg\.wasm: expected a file, found status 404/u },
  ),
  mixture(
    "a web page in place of the wasm module",
    { [MODULE]: { type: "text/html; charset=utf-8" } },
    { code: "type", message: /crease_bg\.wasm: expected a file, found a web page/u },
  ),
  mixture(
    "a wasm module whose download breaks off",
    { [MODULE]: { broken: true } },
    { code: "network", message: /crease_bg\.wasm: expected the whole file/u },
  ),
  mixture(
    "a wasm module that no browser compiles",
    { [MODULE]: { change: (bytes) => bytes.fill(7, 0, 8) } },
    { code: "unsupported", message: /crease_bg\.wasm: expected a module that this browser compiles, found /u },
  ),
  mixture(
    "a worker and a stage that are gone",
    { [WORKER]: { status: 404 }, [STAGE]: { status: 404 } },
    { code: "internal", message: /stage\.js/u },
  ),
  ...[
    ["that is gone", { status: 404 }],
    ["whose place a web page has taken", { type: "text/html" }],
  ].map(([name, answer]) => ({
    name: `faults: without a worker ${name} the page's own thread plays`,
    allows: [/Failed to load resource|MIME type/u],
    run: async ({ server, mount, withAvatar }) => {
      server.instead.set(WORKER, answer);
      await mount();
      assert.ok(server.requests.includes(WORKER));
      assert.equal(await withAvatar((avatar) => avatar.statistics.thread), "main");
    },
  })),
  {
    name: "faults: a browser without memory to map buffers in throws, and nothing asks it to",
    run: async ({ page, mount, withAvatar }) => {
      await mount();
      await page.workers()[0].evaluate(() => {
        const create = GPUDevice.prototype.createBuffer;
        globalThis.buffers = 0;
        GPUDevice.prototype.createBuffer = function (descriptor) {
          if (descriptor.mappedAtCreation) {
            throw new RangeError(
              "createBuffer failed, size is too large for the implementation when mappedAtCreation == true",
            );
          }
          globalThis.buffers += 1;
          return create.call(this, descriptor);
        };
      });
      await withAvatar((avatar) => {
        avatar.src = PLAIN;
        return next(avatar, "load");
      });
      assert.ok((await page.workers()[0].evaluate(() => globalThis.buffers)) > 0);
    },
  },
  {
    name: "faults: a buffer that the browser throws for is an error with the fallback shown, and another worker starts",
    allows: [/./u],
    run: async (tools) => {
      const { page, mount, withAvatar } = tools;
      await mount();
      await page.workers()[0].evaluate(() => {
        GPUDevice.prototype.createBuffer = () => {
          throw new RangeError("createBuffer failed");
        };
      });
      await withAvatar((avatar) => {
        avatar.src = PLAIN;
        return next(avatar, "error");
      });
      const { code, message, shown, gone, error } = await failsAndComesBack(tools, "TINY");
      assert.deepEqual(
        { code, shown, gone, error },
        { code: "internal", shown: true, gone: true, error: null },
        message,
      );
    },
  },
  {
    name: "faults: a GPU that says it is out of memory is left for another device, and after more of it for WebGL2",
    allows: [/out of memory/iu, /instead/u],
    run: async ({ page, mount, withAvatar }) => {
      await mount({ autoplay: true, loop: true, fps: 30 });
      await page.workers()[0].evaluate(() => {
        const create = GPUDevice.prototype.createCommandEncoder;
        globalThis.shortages = 0;
        GPUDevice.prototype.createCommandEncoder = function (...rest) {
          if (!this.told) {
            this.told = true;
            globalThis.shortages += 1;
            const error = new GPUOutOfMemoryError("out of memory");
            setTimeout(() => this.dispatchEvent(new GPUUncapturedErrorEvent("uncapturederror", { error })));
          }
          return create.apply(this, rest);
        };
      });
      const told = await withAvatar(async (avatar) => {
        await until(() => avatar.currentBackend === "webgl2+cpu");
        const { frames } = avatar.statistics;
        await until(() => avatar.statistics.frames > frames + 3);
        return { error: avatar.error, shown: avatar.shadowRoot.querySelector("canvas").checkVisibility() };
      });
      assert.deepEqual(told, { error: null, shown: true });
      assert.equal(await page.workers()[0].evaluate(() => globalThis.shortages), 4);
    },
  },
  {
    name: "faults: a device that is lost and no other to be had is an error with the fallback shown",
    allows: [/Starting again/u, /instead/u],
    run: async (tools) => {
      const { page, mount, withAvatar } = tools;
      await mount({ autoplay: true, loop: true, fps: 30 });
      await page.workers()[0].evaluate(() => {
        const { getContext } = OffscreenCanvas.prototype;
        OffscreenCanvas.prototype.getContext = () => null;
        globalThis.giveContexts = () => {
          OffscreenCanvas.prototype.getContext = getContext;
        };
      });
      await withAvatar((avatar) => {
        const failed = next(avatar, "error");
        avatar.dispatchEvent(new CustomEvent("crease-lose-device"));
        return failed;
      });
      await page.workers()[0]?.evaluate(() => globalThis.giveContexts());
      const { code, message, shown, gone, error } = await failsAndComesBack(tools);
      assert.deepEqual(
        { code, shown, gone, error },
        { code: "unsupported", shown: true, gone: true, error: null },
        message,
      );
    },
  },
  {
    name: "faults: in a page that is hidden for an hour time stands, and goes on from there",
    run: async ({ page, mount, withAvatar }) => {
      await mount({ autoplay: true, fps: 1 });
      // A clock of our own: 10 milliseconds from frame to frame, whatever the machine takes.
      await page.workers()[0].evaluate(() => {
        const request = globalThis.requestAnimationFrame.bind(globalThis);
        globalThis.clock = performance.now();
        globalThis.drawn = 0;
        globalThis.requestAnimationFrame = (draw) =>
          request(() => {
            globalThis.clock += 10;
            globalThis.drawn += 1;
            draw(globalThis.clock);
          });
      });
      const frames = () => page.workers()[0].evaluate(() => globalThis.drawn);
      await withAvatar(async (avatar) => {
        const { frames } = avatar.statistics;
        await until(() => avatar.statistics.frames > frames + 3);
        window.look = (state) => {
          Object.defineProperty(document, "visibilityState", { get: () => state, configurable: true });
          document.dispatchEvent(new Event("visibilitychange"));
        };
        look("hidden");
        await sleep(100);
      });
      const [before, time] = [await frames(), await withAvatar((avatar) => avatar.currentTime)];
      await page.workers()[0].evaluate(() => {
        globalThis.clock += 3_600_000;
      });
      await page.waitForTimeout(300);
      assert.equal(await frames(), before, "nothing is drawn while the page is hidden");
      const after = await withAvatar(async (avatar) => {
        const { frames } = avatar.statistics;
        look("visible");
        await until(() => avatar.statistics.frames >= frames + 3);
        return { time: avatar.currentTime, ended: avatar.ended, paused: avatar.paused };
      });
      const drawn = (await frames()) - before;
      assert.deepEqual({ ...after, time: null }, { time: null, ended: false, paused: false });
      assert.ok(after.time > time, `${after.time} s is later than ${time} s`);
      assert.ok(after.time <= time + 0.01 * drawn, `${time} s, then ${drawn} frames of 10 ms, then ${after.time} s`);
    },
  },
  {
    name: "faults: after a download that broke off the same address is another try",
    allows: [/ERR_CONTENT_LENGTH_MISMATCH|ERR_CONNECTION|ERR_INCOMPLETE/u],
    run: async ({ server, mount, withAvatar }) => {
      server.instead.set("/tests/fixtures/tiny.glb", { broken: true });
      await mount({}, { ready: false });
      const code = await withAvatar(async (avatar) => {
        if (!avatar.error) await next(avatar, "error");
        return avatar.error.code;
      });
      server.instead.clear();
      const after = await withAvatar(async (avatar) => {
        const loaded = next(avatar, "load");
        avatar.src = TINY;
        await loaded;
        return avatar.error;
      });
      assert.deepEqual({ code, after }, { code: "network", after: null });
    },
  },
  {
    name: "faults: after a motion that was gone the avatar stands, and the same address is another try",
    allows: [/404/u],
    run: async ({ server, mount, withAvatar }) => {
      server.instead.set("/tests/fixtures/pickles/motion-numpy2.pkl", { status: 404 });
      await mount({ autoplay: true });
      const { code, url } = await withAvatar(async (avatar) => {
        if (!avatar.error) await next(avatar, "error");
        return { code: avatar.error.code, url: avatar.error.url };
      });
      server.instead.clear();
      const duration = await withAvatar(async (avatar) => {
        const known = next(avatar, "durationchange");
        avatar.motion = MOTION;
        await known;
        const { currentTime } = avatar;
        await until(() => avatar.currentTime > currentTime);
        return avatar.duration;
      });
      assert.equal(code, "http");
      assert.match(url, /motion-numpy2\.pkl$/u);
      assert.ok(duration > 0, `${duration} s`);
    },
  },
  {
    name: "faults: a worker that crashes is an error with the fallback shown, and another starts",
    allows: [/a made fault/u],
    run: async (tools) => {
      await tools.mount();
      await crash(tools.page);
      const { code, message, shown, gone, error } = await failsAndComesBack(tools);
      assert.deepEqual({ code, shown, gone, error }, { code: "internal", shown: true, gone: true, error: null });
      assert.match(message, /a made fault/u);
    },
  },
  {
    name: "faults: a wasm module that traps is an error with the fallback shown, and another starts",
    allows: [/./u],
    run: async (tools) => {
      await tools.mount({ autoplay: true, loop: true });
      await trap(tools.page);
      const { code, shown, gone, error } = await failsAndComesBack(tools);
      assert.deepEqual({ code, shown, gone, error }, { code: "internal", shown: true, gone: true, error: null });
    },
  },
  {
    name: "faults: without WebAssembly it says so and shows the fallback",
    run: async ({ context, mount, withAvatar }) => {
      await context.addInitScript(() => {
        delete window.Worker;
        delete window.WebAssembly;
      });
      await mount({}, { ready: false });
      const told = await withAvatar(async (avatar) => {
        if (!avatar.error) await next(avatar, "error");
        const { code, message } = avatar.error;
        const text = avatar.shadowRoot.querySelector("[part=message]").textContent;
        return { code, message, shown: text.includes(message) };
      });
      assert.deepEqual(told, { code: "unsupported", message: "expected WebAssembly, found none", shown: true });
    },
  },
  {
    name: "faults: without graphics of any kind it says so and shows the fallback",
    allows: [/./u],
    run: async ({ context, open, page }) => {
      await context.addInitScript(() => {
        delete Object.getPrototypeOf(navigator).gpu;
        delete HTMLCanvasElement.prototype.transferControlToOffscreen;
        HTMLCanvasElement.prototype.getContext = () => null;
      });
      await open();
      const told = await page.evaluate(async () => {
        const avatar = make({ backend: null });
        const fallback = document.createElement("p");
        fallback.slot = "fallback";
        fallback.textContent = "No avatar here.";
        avatar.append(fallback);
        const failed = next(avatar, "error");
        document.body.append(avatar);
        const { error } = await failed;
        return {
          code: error.code,
          shown: fallback.checkVisibility(),
          canvas: avatar.shadowRoot.querySelector("canvas") !== null,
        };
      });
      assert.deepEqual(told, { code: "unsupported", shown: true, canvas: false });
    },
  },
];
