/**
 * Takes a picture of one page that stands still, for `cargo xtask test`.
 *
 * The only argument is a JSON object: { url, chromium, flags, firefox, limitMilliseconds, picture, side, loseDevice }. With `loseDevice` the graphics device
 * is taken away first, and the picture is the one after that. Prints one JSON object: { problems, backend, currentTime }.
 */

import process from "node:process";
import { withPage } from "./page.mjs";

const USUAL_SIDE = 480;

const order = JSON.parse(process.argv[2] ?? "null");

const side = order.side ?? USUAL_SIDE;

await withPage(order, { width: side, height: side }, async (page, result) => {
  if (order.loseDevice) {
    await page.evaluate(loseDevice, order.limitMilliseconds);
  }
  await page.evaluate(fadedIn);
  await page.screenshot({ path: order.picture });
  Object.assign(
    result,
    await page.evaluate(() => {
      const { currentBackend, currentTime } = document.querySelector("crease-avatar");
      return { backend: currentBackend, currentTime };
    }),
  );
});

/** Runs in the page: takes the device away and waits for the first picture of the next one. */
async function loseDevice(limitMilliseconds) {
  const element = document.querySelector("crease-avatar");
  const until = Date.now() + limitMilliseconds;
  const waitFor = async (holds) => {
    while (!holds()) {
      if (Date.now() > until) {
        throw new Error(`no picture ${limitMilliseconds} ms after the device was lost`);
      }
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  };
  let rebuilt = false;
  element.addEventListener("backendchange", () => {
    rebuilt = true;
  });
  const canvas = element.shadowRoot.querySelector("canvas");
  element.dispatchEvent(new CustomEvent("crease-lose-device"));
  await waitFor(() => rebuilt);
  // A picture on the next canvas takes the old canvas away.
  await waitFor(() => !canvas.isConnected);
}

/** Runs in the page: waits until nothing in the element fades any more. */
async function fadedIn() {
  const { shadowRoot } = document.querySelector("crease-avatar");
  for (let fades = [null]; fades.length > 0; fades = shadowRoot.getAnimations()) {
    await Promise.allSettled(fades.map((fade) => fade?.finished));
    // Two frames: a transition starts in the first.
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  }
}
