/**
 * Runs the cases of the element in one headless Chromium, for `cargo xtask test`.
 *
 * The first argument is a JSON object: { chromium, flags, more, files, only }. `more` are flags beside the usual ones, `files` modules whose default
 * export is a list of cases, and `only` is a part of the names of those that shall run, or null. Prints a line for each case, and ends with 1 if one has failed or none has run.
 *
 * A case is { name, run, allows, limit }: `run` gets the tools below and throws where something does not hold, or after `limit` milliseconds;
 * `allows` are patterns of what a
 * developer may see in red in the console during it. Anything else there fails the case, warnings included.
 */

import assert from "node:assert/strict";
import process from "node:process";
import { chromium } from "playwright-core";
import { startServer } from "./server.mjs";

const VIEWPORT = { width: 400, height: 400 };
/** A software renderer on a busy machine needs its time. */
const LIMIT_MILLISECONDS = 300_000;

const order = JSON.parse(process.argv[2] ?? "null");
const server = await startServer();
const browser = await chromium.launch({ executablePath: order.chromium, args: [...order.flags, ...order.more] });
let failures = 0;
let count = 0;
try {
  for (const file of order.files) {
    const { default: cases } = await import(new URL(file, import.meta.url));
    for (const one of cases) {
      if (order.only && !one.name.includes(order.only)) continue;
      count += 1;
      failures += (await passes(one)) ? 0 : 1;
    }
  }
} finally {
  await browser.close();
  server.close();
}
console.log(failures > 0 ? `${failures} of ${count} cases failed` : `${count} cases passed`);
process.exitCode = failures > 0 || count === 0 ? 1 : 0;

async function passes({ name, run, allows = [], context: options = {}, limit = LIMIT_MILLISECONDS }) {
  const started = performance.now();
  const context = await browser.newContext({ viewport: VIEWPORT, deviceScaleFactor: 1, ...options });
  context.setDefaultTimeout(LIMIT_MILLISECONDS);
  await context.addInitScript(pageTools);
  const page = await context.newPage();
  const problems = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) problems.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => problems.push(`uncaught: ${error.message}`));
  page.on("crash", () => problems.push("the page crashed"));
  server.requests.length = 0;
  server.instead.clear();
  let reason = null;
  try {
    await within(limit, run(tools(page)));
    const noise = problems.filter((problem) => !allows.some((pattern) => pattern.test(problem)));
    assert.deepEqual(noise, [], "the console is not quiet");
  } catch (error) {
    reason = error instanceof Error ? error.message : String(error);
    if (problems.length > 0) reason += `\n      ${problems.join("\n      ")}`;
  }
  await context.close();
  const milliseconds = Math.round(performance.now() - started);
  console.log(
    reason === null ? `ok      ${name} (${milliseconds} ms)` : `FAILED  ${name} (${milliseconds} ms)\n      ${reason}`,
  );
  return reason === null;
}

/** What a case works with. */
function tools(page) {
  const open = (query = "") => page.goto(`${server.origin}/blank.html${query}`, { waitUntil: "load" });
  return {
    page,
    server,
    context: page.context(),
    open,
    /** Opens the page, puts an element with these attributes into it, and waits for its first picture unless told not to. */
    mount: async (attributes = {}, { ready = true, query = "" } = {}) => {
      await open(query);
      await page.evaluate((wanted) => window.put(wanted), attributes);
      if (ready) await page.evaluate(() => document.querySelector("crease-avatar").ready);
    },
    /** Runs `action` in the page with the element, and an argument. */
    withAvatar: (action, argument) =>
      page.evaluate(`(${action})(document.querySelector("crease-avatar"), ${JSON.stringify(argument ?? null)})`),
    pause: (milliseconds) => page.waitForTimeout(milliseconds),
    /** A page of another Chromium, which has no WebGPU; it is closed with the page. */
    pageWithoutWebGpu: async () => {
      const args = order.flags.filter((flag) => !/webgpu|vulkan/iu.test(flag));
      const other = await chromium.launch({ executablePath: order.chromium, args });
      const plain = await other.newPage();
      plain.on("close", () => void other.close());
      await plain.addInitScript(pageTools);
      return plain;
    },
  };
}

function within(milliseconds, promise) {
  const late = new Promise((_, reject) => {
    setTimeout(() => reject(new Error(`not done after ${milliseconds} ms`)), milliseconds).unref();
  });
  return Promise.race([promise, late]);
}

/** Runs in every page before its own scripts. */
function pageTools() {
  window.TINY = "/tests/fixtures/tiny.glb";
  window.PLAIN = "/tests/fixtures/tiny_plain.glb";
  window.MOTION = "/tests/fixtures/pickles/motion-numpy2.pkl";
  /** Makes an element; `true` stands for an attribute without a value, null for none. */
  window.make = (attributes = {}) => {
    const element = document.createElement("crease-avatar");
    const usual = { src: window.TINY, motion: window.MOTION, fps: 2, backend: "webgpu+cpu" };
    for (const [name, value] of Object.entries({ ...usual, ...attributes })) {
      if (value !== null) element.setAttribute(name, value === true ? "" : String(value));
    }
    return element;
  };
  window.put = (attributes) => {
    document.body.append(window.make(attributes));
  };
  /** Resolves with the next event of that name. */
  window.next = (element, name) => new Promise((resolve) => element.addEventListener(name, resolve, { once: true }));
  /** Collects the names of these events, in order, from now on. */
  window.listen = (element, names) => {
    const heard = [];
    for (const name of names) element.addEventListener(name, () => heard.push(name));
    return heard;
  };
  window.until = async (holds) => {
    while (!(await holds())) await new Promise((resolve) => setTimeout(resolve, 20));
  };
  window.sleep = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));
}
