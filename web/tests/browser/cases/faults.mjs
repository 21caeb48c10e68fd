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

export default [
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
