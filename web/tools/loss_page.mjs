/**
 * Takes the graphics device away from one page while its avatar plays, in headless Chromium, for `cargo xtask test`.
 *
 * The only argument is a JSON object: { url, chromium, flags, limitMilliseconds, picture }. Prints one JSON object:
 * { problems, backend, before, after, later, milliseconds, playing }, with the motion's time at the last picture before the loss, at the
 * first one after it, and some pictures on; the milliseconds from the loss to that first picture; and whether it still plays then.
 */

import process from "node:process";
import { withPage } from "./page.mjs";

const VIEWPORT = { width: 480, height: 480 };

const order = JSON.parse(process.argv[2] ?? "null");

await withPage(order, VIEWPORT, async (page, result) => {
  Object.assign(result, await page.evaluate(loseWhilePlaying, order.limitMilliseconds));
  await page.screenshot({ path: order.picture });
});

/** Runs in the page. */
async function loseWhilePlaying(limitMilliseconds) {
  const element = document.querySelector("crease-avatar");
  const until = performance.now() + limitMilliseconds;
  const waitFor = async (what, holds) => {
    while (!holds()) {
      if (performance.now() > until) {
        throw new Error(`no ${what} in ${limitMilliseconds} ms`);
      }
      await new Promise((resolve) => setTimeout(resolve, 5));
    }
  };
  const frames = () => element.statistics.frames;
  await waitFor("moving picture", () => frames() > 3 && element.currentTime > 0);
  const canvas = element.shadowRoot.querySelector("canvas");
  const before = element.currentTime;
  const lost = performance.now();
  element.dispatchEvent(new CustomEvent("crease-lose-device"));
  // A picture on the next canvas takes the old canvas away.
  await waitFor("picture after the loss", () => !canvas.isConnected);
  const milliseconds = performance.now() - lost;
  const [after, shown] = [element.currentTime, frames()];
  await waitFor("further pictures", () => frames() > shown + 3);
  const { currentBackend: backend, currentTime: later, paused } = element;
  return { backend, before, after, later, milliseconds, playing: !paused };
}
