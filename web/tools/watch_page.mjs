/**
 * Watches one page play in headless Chromium, for `cargo xtask play --check`.
 *
 * The only argument is a JSON object: { url, chromium, flags, frames, limitMilliseconds, before, after }. Two pictures
 * are saved, half-way (`before`) and once `frames` frames were drawn (`after`). Prints one JSON object:
 * { problems, region, statistics }, where the region is the element's place on the page in pixels.
 */

import process from "node:process";
import { withPage } from "./page.mjs";

const VIEWPORT = { width: 1280, height: 800 };

const order = JSON.parse(process.argv[2] ?? "null");

await withPage(order, VIEWPORT, async (page, result) => {
  const middle = await waitForFrames(page, Math.ceil(order.frames / 2));
  await page.screenshot({ path: order.before });
  // The first picture itself may take some frames.
  await waitForFrames(page, Math.max(order.frames, middle + Math.ceil(order.frames / 4)));
  await page.screenshot({ path: order.after });
  result.statistics = await page.evaluate(() => document.querySelector("crease-avatar").statistics);
  result.region = await page.locator("crease-avatar").first().boundingBox();
});

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
