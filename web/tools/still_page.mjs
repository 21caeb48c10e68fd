/**
 * Takes a picture of one page that stands still, for `cargo xtask test`.
 *
 * The only argument is a JSON object: { url, chromium, flags, firefox, limitMilliseconds, picture, loseDevice }. With `loseDevice` the graphics device
 * is taken away first, and the picture is the one after that. Prints one JSON object: { problems, backend, currentTime }.
 */

import process from "node:process";
import { setTimeout as sleep } from "node:timers/promises";
import { withPage } from "./page.mjs";

const VIEWPORT = { width: 480, height: 480 };
/** The element fades in. */
const FADE_MILLISECONDS = 600;

const order = JSON.parse(process.argv[2] ?? "null");

await withPage(order, VIEWPORT, async (page, result) => {
  if (order.loseDevice) {
    await page.evaluate(loseDevice, order.limitMilliseconds);
  }
  await sleep(FADE_MILLISECONDS);
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
