/** What the tools that open a page in a browser share. */

import process from "node:process";
import { setTimeout as sleep } from "node:timers/promises";
import { chromium } from "playwright-core";

/**
 * Opens `order.url` in a browser, lets `use(page, result)` work on it, and prints `result`, with all that a developer would see in red in
 * `result.problems`, as one JSON object. The browser is `order.chromium` with `order.flags`, or `order.firefox`. What a page of either can do:
 * `evaluate`, `screenshot`.
 */
export async function withPage(order, viewport, use) {
  const result = { problems: [] };
  const browser = order.firefox ? await launchFirefox(order.firefox) : await launchChromium(order);
  try {
    const page = await newPage(browser, order, viewport);
    page.setDefaultTimeout(order.limitMilliseconds);
    collectProblems(page, result.problems);
    await page.goto(order.url, { waitUntil: "load" });
    await page.evaluate(waitUntilReady, order.limitMilliseconds);
    await use(page, result);
  } catch (error) {
    result.problems.push(firstLine(error));
  } finally {
    await browser.close();
  }
  process.stdout.write(`${JSON.stringify(result)}\n`);
}

/** Headless Chromium. */
export function launchChromium(order) {
  return chromium.launch({ executablePath: order.chromium, args: order.flags });
}

/** Firefox on whatever screen there is: without one it has no WebGL. */
async function launchFirefox(executablePath) {
  const { default: puppeteer } = await import("puppeteer-core");
  return puppeteer.launch({ browser: "firefox", executablePath, headless: false });
}

async function newPage(browser, order, viewport) {
  if (!order.firefox) return browser.newPage({ viewport, deviceScaleFactor: 1 });
  const page = await browser.newPage();
  await page.setViewport(viewport);
  return page;
}

/** What an error says; further lines are the call stack. */
export function firstLine(error) {
  return String(error instanceof Error ? error.message : error).split("\n")[0];
}

/** Adds to `problems` what a developer would see in red. */
export function collectProblems(page, problems) {
  page.on("console", (message) => {
    if (message.type() === "error") {
      problems.push(`console: ${message.text()}`);
    }
  });
  page.on("pageerror", (error) => problems.push(`uncaught: ${error.message}`));
  page.on("crash", () => problems.push("the page crashed"));
  page.on("requestfailed", (request) => {
    const reason = request.failure()?.errorText;
    // Browsers say so now and then of what a worker has read to its end. A download that does break off is the element's error.
    if (reason !== "net::ERR_ABORTED" && reason !== "NS_BINDING_ABORTED") {
      problems.push(`${request.url()}: ${reason}`);
    }
  });
  page.on("response", (response) => {
    if (response.status() >= 400) {
      problems.push(`${response.url()}: HTTP status ${response.status()}`);
    }
  });
}

/** Waits until `element.statistics` counts that many frames; returns how many there are. */
export async function waitForFrames(page, wanted, limitMilliseconds) {
  const drawn = () => page.evaluate(() => document.querySelector("crease-avatar").statistics?.frames ?? 0);
  const deadline = Date.now() + limitMilliseconds;
  let frames = await drawn();
  while (frames < wanted) {
    const message = await page.evaluate(() => document.querySelector("crease-avatar").error?.message ?? null);
    if (message !== null) {
      throw new Error(`<crease-avatar>: ${message}`);
    }
    if (Date.now() > deadline) {
      throw new Error(`${frames} frames in ${limitMilliseconds} ms, expected ${wanted}`);
    }
    await sleep(100);
    frames = await drawn();
  }
  return frames;
}

/** Runs in the page: resolves when the element is ready, rejects with its reason. */
async function waitUntilReady(limitMilliseconds) {
  const late = new Promise((_, reject) => {
    setTimeout(() => reject(new Error(`not ready after ${limitMilliseconds} ms`)), limitMilliseconds);
  });
  await Promise.race([customElements.whenDefined("crease-avatar"), late]);
  // A framework may put the element into the page a little later.
  while (document.querySelector("crease-avatar") === null) {
    await Promise.race([new Promise((resolve) => setTimeout(resolve, 20)), late]);
  }
  await Promise.race([document.querySelector("crease-avatar").ready, late]);
}
