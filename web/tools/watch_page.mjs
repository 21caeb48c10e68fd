/**
 * Watches one page play, for `cargo xtask play --check`.
 *
 * The only argument is a JSON object: { url, chromium, flags, firefox, frames, limitMilliseconds, before, after }. Two pictures
 * are saved, half-way (`before`) and once `frames` frames were drawn (`after`). Prints one JSON object:
 * { problems, region, statistics }, where the region is the element's place on the page in pixels.
 */

import process from "node:process";
import { waitForFrames, withPage } from "./page.mjs";

const VIEWPORT = { width: 1280, height: 800 };

const order = JSON.parse(process.argv[2] ?? "null");

await withPage(order, VIEWPORT, async (page, result) => {
  const middle = await waitForFrames(page, Math.ceil(order.frames / 2), order.limitMilliseconds);
  await page.screenshot({ path: order.before });
  // The first picture itself may take some frames.
  const wanted = Math.max(order.frames, middle + Math.ceil(order.frames / 4));
  await waitForFrames(page, wanted, order.limitMilliseconds);
  await page.screenshot({ path: order.after });
  result.statistics = await page.evaluate(() => document.querySelector("crease-avatar").statistics);
  result.region = await page.evaluate(() => {
    const { x, y, width, height } = document.querySelector("crease-avatar").getBoundingClientRect();
    return { x, y, width, height };
  });
});
