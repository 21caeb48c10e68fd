/** What the tools that open a page in headless Chromium share. */

import process from "node:process";
import { chromium } from "playwright-core";

/**
 * Opens `order.url` with `order.chromium` and `order.flags`, lets `use(page, result)` work on it, and prints `result`, with all that
 * a developer would see in red in `result.problems`, as one JSON object.
 */
export async function withPage(order, viewport, use) {
  const result = { problems: [] };
  const browser = await chromium.launch({ executablePath: order.chromium, args: order.flags });
  try {
    const page = await browser.newPage({ viewport, deviceScaleFactor: 1 });
    page.setDefaultTimeout(order.limitMilliseconds);
    collectProblems(page, result.problems);
    await page.goto(order.url, { waitUntil: "load" });
    await page.waitForFunction(() => customElements.get("crease-avatar") !== undefined, undefined, { timeout: 30_000 });
    await page.evaluate(waitUntilReady, order.limitMilliseconds);
    await use(page, result);
  } catch (error) {
    // Further lines are Playwright's call stack.
    const [reason] = String(error instanceof Error ? error.message : error).split("\n");
    result.problems.push(reason);
  } finally {
    await browser.close();
  }
  process.stdout.write(`${JSON.stringify(result)}\n`);
}

function collectProblems(page, problems) {
  page.on("console", (message) => {
    if (message.type() === "error") {
      problems.push(`console: ${message.text()}`);
    }
  });
  page.on("pageerror", (error) => problems.push(`uncaught: ${error.message}`));
  page.on("crash", () => problems.push("the page crashed"));
  page.on("requestfailed", (request) => {
    const reason = request.failure()?.errorText;
    // Chromium says so now and then of what a worker has read to its end. A download that does break off is the element's error.
    if (reason !== "net::ERR_ABORTED") {
      problems.push(`${request.url()}: ${reason}`);
    }
  });
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
