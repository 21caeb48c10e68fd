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
function failsAndComesBack({ withAvatar }) {
  return withAvatar(async (avatar) => {
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
    avatar.src = PLAIN;
    await loaded;
    return { code, message, shown, gone: !fallback.checkVisibility(), error: avatar.error, seconds };
  });
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
