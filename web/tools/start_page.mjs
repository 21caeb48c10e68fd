/**
 * Watches one page start in headless Chromium, for `cargo xtask test`.
 *
 * The only argument is a JSON object: { url, chromium, flags, limitMilliseconds }. Waits for the first picture with detail and prints one
 * JSON object: { problems, backend, warnings, atLoad, after }, the last two the element's statistics at its first picture and then.
 */

import process from "node:process";
import { withPage } from "./page.mjs";

const VIEWPORT = { width: 320, height: 320 };

const order = JSON.parse(process.argv[2] ?? "null");

await withPage(order, VIEWPORT, async (page, result) => {
  const hasDetail = () => document.querySelector("crease-avatar").statistics.firstDetailMilliseconds !== null;
  await page.waitForFunction(hasDetail, null, { timeout: order.limitMilliseconds });
  Object.assign(
    result,
    await page.evaluate(() => {
      const { currentBackend, statistics } = document.querySelector("crease-avatar");
      return { backend: currentBackend, ...globalThis.seen, after: statistics };
    }),
  );
});
