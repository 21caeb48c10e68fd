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
const NOISE = { heap: 4 << 20, wasm: 4 << 20, nodes: 50, listeners: 20, workers: 0, buffers: 8 };

/** Counts the worker's GPU buffers from now on: those made less those destroyed. */
function countBuffers(worker) {
  return worker.evaluate(() => {
    if (typeof GPUDevice !== "function" || globalThis.buffers !== undefined) return;
    globalThis.buffers = 0;
    const create = GPUDevice.prototype.createBuffer;
    GPUDevice.prototype.createBuffer = function (...rest) {
      globalThis.buffers += 1;
      return create.apply(this, rest);
    };
    const destroy = GPUBuffer.prototype.destroy;
    GPUBuffer.prototype.destroy = function (...rest) {
      globalThis.buffers -= 1;
      return destroy.apply(this, rest);
    };
  });
}

async function measure({ page }, session) {
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize } = await session.send("Runtime.getHeapUsage");
  const { nodes, jsEventListeners } = await session.send("Memory.getDOMCounters");
  const workers = page.workers();
  const inside = await workers[0].evaluate(async () => {
    const { default: initialise } = await import("/web/pkg/crease.js");
    const { memory } = await initialise();
    return { wasm: memory.buffer.byteLength, buffers: globalThis.buffers ?? 0 };
  });
  return { heap: usedSize, nodes, listeners: jsEventListeners, workers: workers.length, ...inside };
}

/** Runs in the page: `count` times what `action` names. */
function use(action, count) {
  return `(async () => {
    const avatars = [...document.querySelectorAll("crease-avatar")];
    for (let i = 0; i < ${count}; i += 1) {
      const avatar = avatars[i % avatars.length];
      await (${action})(avatar, i);
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
    const loaded = next(avatar, "load");
    avatar.src = i % 2 === 0 ? PLAIN : TINY;
    // Every fifth is overtaken by another address: its promise must not be dropped.
    if (i % 5 === 0) {
      const overtaken = avatar.ready.catch(() => null);
      avatar.src = i % 2 === 0 ? TINY : PLAIN;
      await overtaken;
    }
    await loaded;
  },
  cycles: async () => {
    const avatar = make({ style: "inline-size: 80px; block-size: 80px; float: left", autoplay: true });
    document.body.append(avatar);
    await avatar.ready;
    avatar.remove();
  },
};

export default [
  {
    name: "soak: what a page holds is flat after the warm-up",
    limit: 3_600_000,
    run: async (tools) => {
      const { open, page, context } = tools;
      await open();
      const session = await context.newCDPSession(page);
      await page.evaluate(async (count) => {
        const avatars = Array.from({ length: count }, () =>
          make({ style: "inline-size: 80px; block-size: 80px; float: left", autoplay: true, loop: true }),
        );
        document.body.append(...avatars);
        await Promise.all(avatars.map((avatar) => avatar.ready));
      }, plan.avatars);
      await countBuffers(page.workers()[0]);
      // The warm-up: a little of everything.
      for (const action of Object.values(ACTIONS)) await page.evaluate(use(action, plan.avatars));
      const told = [];
      const tell = async (stage) => {
        const counts = await measure(tools, session);
        told.push({ stage, ...counts });
        console.log(JSON.stringify(told.at(-1)));
      };
      await tell("warm");
      const began = performance.now();
      for (const [name, action] of Object.entries(ACTIONS)) {
        for (let part = 0; part < 4; part += 1) await page.evaluate(use(action, Math.ceil(plan[name] / 4)));
        await tell(name);
      }
      while (performance.now() - began < 60_000 * plan.minutes) {
        await page.waitForTimeout(15_000);
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
