/**
 * Watches one page play in headless Chromium, for `cargo xtask play --check`.
 *
 * The only argument is a JSON object: { url, chromium, flags, frames, limitMilliseconds, before, after }. Two pictures
 * are saved, half-way (`before`) and once `frames` frames were drawn (`after`). Prints one JSON object:
 * { problems, region, statistics }, where the region is the element's place on the page in pixels.
 */

import process from "node:process";
import { chromium } from "playwright-core";

const VIEWPORT = { width: 1280, height: 800 };

const order = JSON.parse(process.argv[2] ?? "null");
const result = { problems: [], region: null, statistics: null };
const browser = await chromium.launch({ executablePath: order.chromium, args: order.flags });
try {
  const page = await browser.newPage({ viewport: VIEWPORT, deviceScaleFactor: 1 });
  page.setDefaultTimeout(order.limitMilliseconds);
  collectProblems(page, result.problems);
  await watch(page);
} catch (error) {
  // Further lines are Playwright's call stack.
  const [reason] = String(error instanceof Error ? error.message : error).split("\n");
  result.problems.push(reason);
} finally {
  await browser.close();
}
process.stdout.write(`${JSON.stringify(result)}\n`);

/** Plays the page up to the wanted number of frames and fills in the result. */
async function watch(page) {
  await page.goto(order.url, { waitUntil: "load" });
  await page.waitForFunction(() => customElements.get("crease-avatar") !== undefined, undefined, { timeout: 30_000 });
  await page.evaluate(waitUntilReady, order.limitMilliseconds);
  const middle = await waitForFrames(page, Math.ceil(order.frames / 2));
  await page.screenshot({ path: order.before });
  // The first picture itself may take some frames.
  await waitForFrames(page, Math.max(order.frames, middle + Math.ceil(order.frames / 4)));
  await page.screenshot({ path: order.after });
  result.statistics = await page.evaluate(() => document.querySelector("crease-avatar").statistics);
  result.region = await page.locator("crease-avatar").first().boundingBox();
}

/** Everything that a developer would see in red. */
function collectProblems(page, problems) {
  page.on("console", (message) => {
    if (message.type() === "error") {
      problems.push(`console: ${message.text()}`);
    }
  });
  page.on("pageerror", (error) => problems.push(`uncaught: ${error.message}`));
  page.on("crash", () => problems.push("the page crashed"));
  page.on("requestfailed", (request) => problems.push(`${request.url()}: ${request.failure()?.errorText}`));
  page.on("response", (response) => {
    if (response.status() >= 400) {
      problems.push(`${response.url()}: HTTP status ${response.status()}`);
    }
  });
}

/** Runs in the page: resolves when the element is ready, rejects with its reason. */
async function waitUntilReady(limitMilliseconds) {
  const element = document.querySelector("crease-avatar");
  if (element === null) {
    throw new Error("the page has no <crease-avatar>");
  }
  const late = new Promise((_, reject) => {
    setTimeout(() => reject(new Error(`not ready after ${limitMilliseconds} ms`)), limitMilliseconds);
  });
  await Promise.race([element.ready, late]);
}

/** Waits until that many frames were drawn; returns how many were. */
async function waitForFrames(page, wanted) {
  const drawn = () => page.evaluate(() => document.querySelector("crease-avatar").statistics?.frames ?? 0);
  const deadline = Date.now() + order.limitMilliseconds;
  let frames = await drawn();
  while (frames < wanted) {
    const message = await page.evaluate(() => document.querySelector("crease-avatar").error?.message ?? null);
    if (message !== null) {
      throw new Error(`<crease-avatar>: ${message}`);
    }
    if (Date.now() > deadline) {
      throw new Error(`${frames} frames in ${order.limitMilliseconds} ms, expected ${wanted}`);
    }
    await page.waitForTimeout(100);
    frames = await drawn();
  }
  return frames;
}
