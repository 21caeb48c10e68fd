/**
 * Long use of a page, for `cargo xtask soak`: many avatars, put in and taken out, sought in, given other addresses. What they hold is counted,
 * and must be flat after the warm-up.
 *
 * CREASE_SOAK is a JSON object: { avatars, cycles, seeks, swaps, minutes }.
 */

import assert from "node:assert/strict";
import process from "node:process";

const plan = {
  avatars: 16,
  cycles: 300,
  seeks: 1000,
  swaps: 500,
  minutes: 10,
  ...JSON.parse(process.env.CREASE_SOAK ?? "{}"),
};

/** Growth that is noise: collectors and allocators keep something back. */
const NOISE = { heap: 4 << 20, wasm: 4 << 20, nodes: 50, listeners: 20, workers: 0, buffers: 8, bufferBytes: 1 << 20 };

/** Milliseconds that one load or one seek may take before it counts as never done: the machine may be slow, and 16 avatars draw meanwhile. */
const PATIENCE = 60_000;

/** What `promise` resolves with, or an error that says what was waited for. */
function within(milliseconds, what, promise) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`${what}: not done after ${milliseconds} ms`)), milliseconds);
  });
  return Promise.race([promise, late]).finally(() => clearTimeout(timer));
}

/** Counts the worker's GPU buffers from now on: those made less those destroyed or collected, and their bytes. */
function countBuffers(worker) {
  return worker.evaluate(() => {
    if (typeof GPUDevice !== "function" || globalThis.held) return;
    const held = { buffers: 0, bytes: 0 };
    globalThis.held = held;
    // Bytes of the buffers that are neither destroyed nor collected, by a token that outlives them.
    const living = new Map();
    const tokens = new WeakMap();
    const forget = (token) => {
      if (!living.has(token)) return;
      held.buffers -= 1;
      held.bytes -= living.get(token);
      living.delete(token);
    };
    const registry = new FinalizationRegistry(forget);
    const create = GPUDevice.prototype.createBuffer;
    GPUDevice.prototype.createBuffer = function (...rest) {
      const buffer = create.apply(this, rest);
      const token = Symbol("buffer");
      tokens.set(buffer, token);
      living.set(token, buffer.size);
      held.buffers += 1;
      held.bytes += buffer.size;
      registry.register(buffer, token);
      return buffer;
    };
    const destroy = GPUBuffer.prototype.destroy;
    GPUBuffer.prototype.destroy = function () {
      forget(tokens.get(this));
      destroy.call(this);
    };
  });
}

/** What page and worker hold after their garbage is collected. Runs with V8's `--expose-gc`, as no protocol reaches a worker's collector. */
async function measure({ page }, session) {
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize } = await session.send("Runtime.getHeapUsage");
  const { nodes, jsEventListeners } = await session.send("Memory.getDOMCounters");
  const workers = page.workers();
  const inside = await workers[0].evaluate(async () => {
    const uncollected = globalThis.held?.bytes ?? 0;
    // Finalisers run in a task of their own.
    for (let i = 0; i < 3; i += 1) {
      globalThis.gc?.();
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
    const { default: initialise } = await import("/web/pkg/crease.js");
    const { memory } = await initialise();
    const { buffers, bytes } = globalThis.held ?? { buffers: 0, bytes: 0 };
    return { wasm: memory.buffer.byteLength, buffers, bufferBytes: bytes, uncollected };
  });
  return { heap: usedSize, nodes, listeners: jsEventListeners, workers: workers.length, ...inside };
}

/** Runs in the page: what `action` names, for each number from `first` to `last`. Each has its limit, and says what it found when it is over. */
function use(action, first, last) {
  return `(async () => {
    const avatars = [...document.querySelectorAll("crease-avatar")];
    const within = ${within};
    for (let i = ${first}; i < ${last}; i += 1) {
      const avatar = avatars[i % avatars.length];
      try {
        await within(${PATIENCE}, "number " + i, (${action})(avatar, i));
      } catch (error) {
        const { src, loaded, seeking, currentTime, paused, statistics: { frames } } = avatar;
        throw new Error(error.message + ": " + JSON.stringify({ src, loaded, seeking, currentTime, paused, frames }));
      }
    }
  })()`;
}

const ACTIONS = {
  seeks: async (avatar, i) => {
    const sought = next(avatar, "seeked");
    avatar.currentTime = (avatar.duration * ((i * 37) % 101)) / 101;
    await sought;
  },
  swaps: async (avatar, i) => {
    // The address that it has already would load nothing.
    const others = avatar.src === TINY ? [PLAIN, TINY] : [TINY, PLAIN];
    avatar.src = others[0];
    // It opens once the page's own code is done.
    await sleep(0);
    const first = avatar.ready;
    // Every fifth is overtaken by another address: whoever waits for the first must hear of the second.
    if (i % 5 === 0) {
      avatar.src = others[1];
      await sleep(0);
    }
    await first;
    await avatar.ready;
  },
  cycles: async () => {
    const avatar = make({ style: "inline-size: 80px; block-size: 80px; float: left", autoplay: true });
    document.body.append(avatar);
    avatar.scrollIntoView();
    await avatar.ready;
    avatar.remove();
  },
};

export default [
  {
    name: "soak: what a page holds is flat after the warm-up",
    // Every wait has its own; a busy machine may need hours.
    limit: 36_000_000,
    run: async (tools) => {
      const { open, page, context } = tools;
      const began = performance.now();
      const say = (what) => console.log(`${((performance.now() - began) / 1000).toFixed(0)} s: ${what}`);
      say(`opening ${plan.avatars} avatars`);
      await open();
      const session = await context.newCDPSession(page);
      // The first one starts the worker, so that all buffers of the others can be counted.
      for (const count of [1, plan.avatars - 1]) {
        const opened = page.evaluate(async (wanted) => {
          const avatars = Array.from({ length: wanted }, () =>
            make({ style: "inline-size: 80px; block-size: 80px; float: left", autoplay: true, loop: true }),
          );
          document.body.append(...avatars);
          await Promise.all(avatars.map((avatar) => avatar.ready));
        }, count);
        await within(plan.avatars * PATIENCE, "the first pictures", opened);
        await countBuffers(page.workers()[0]);
      }
      const act = async (name, first, last) => {
        say(`${name} ${first} to ${last}`);
        const most = (last - first + 1) * PATIENCE;
        await within(most, `${name} ${first} to ${last}`, page.evaluate(use(ACTIONS[name], first, last))).catch(
          (error) => {
            throw new Error(`${name}: ${error.message}`);
          },
        );
      };
      // The warm-up: a little of everything, and every avatar exchanged.
      for (const name of Object.keys(ACTIONS)) await act(name, 0, plan.avatars);
      const told = [];
      const tell = async (stage) => {
        const counts = await within(PATIENCE, "counting", measure(tools, session));
        told.push({ stage, ...counts });
        console.log(JSON.stringify(told.at(-1)));
      };
      await tell("warm");
      for (const name of Object.keys(ACTIONS)) {
        const part = Math.ceil(plan[name] / 4);
        for (let first = 0; first < plan[name]; first += part) {
          await act(name, first, Math.min(first + part, plan[name]));
          await tell(name);
        }
      }
      const enough = 60_000 * plan.minutes;
      while (performance.now() - began < enough) {
        const left = enough - (performance.now() - began);
        say("playing");
        await page.waitForTimeout(Math.min(left, 15_000));
        await tell("playing");
      }
      const frames = await page.evaluate(() =>
        [...document.querySelectorAll("crease-avatar")].map((avatar) => avatar.statistics.frames),
      );
      assert.ok(
        frames.every((count) => count > 0),
        `every avatar has drawn: ${frames}`,
      );
      const [warm, ...later] = told;
      for (const counts of later) {
        for (const [name, noise] of Object.entries(NOISE)) {
          assert.ok(
            counts[name] - warm[name] <= noise,
            `${counts.stage}: ${name}: ${warm[name]} warm, ${counts[name]} after`,
          );
        }
      }
    },
  },
];
