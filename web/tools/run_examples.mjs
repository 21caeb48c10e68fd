/**
 * Opens the documentation's examples one after the other in headless Chromium, for `cargo xtask docs --check`.
 *
 * The only argument is a JSON object: { urls, chromium, flags, limitMilliseconds }. Each avatar
 * that a page names must become ready. Prints a JSON list of { url, problems }.
 */

import process from "node:process";
import { setTimeout as sleep } from "node:timers/promises";
import { collectProblems, firstLine, launchChromium } from "./page.mjs";

const VIEWPORT = { width: 320, height: 320 };
/** What an example does once its avatar is ready. */
const GRACE_MILLISECONDS = 400;

const order = JSON.parse(process.argv[2] ?? "null");
const browser = await launchChromium(order);
const told = [];
try {
  for (const url of order.urls) {
    told.push({ url, problems: await run(url) });
  }
} finally {
  await browser.close();
}
process.stdout.write(`${JSON.stringify(told)}\n`);

async function run(url) {
  const problems = [];
  const page = await browser.newPage({ viewport: VIEWPORT, deviceScaleFactor: 1 });
  page.setDefaultTimeout(order.limitMilliseconds);
  collectProblems(page, problems);
  try {
    await page.goto(url, { waitUntil: "load" });
    await page.evaluate(allReady, order.limitMilliseconds);
    await sleep(GRACE_MILLISECONDS);
  } catch (error) {
    problems.push(firstLine(error));
  } finally {
    await page.close();
  }
  return problems;
}

/** Runs in the page. */
async function allReady(limitMilliseconds) {
  await customElements.whenDefined("crease-avatar");
  const avatars = [...document.querySelectorAll("crease-avatar")];
  if (avatars.length === 0) throw new Error("the example has no <crease-avatar>");
  const late = new Promise((_, reject) => {
    setTimeout(() => reject(new Error(`not ready after ${limitMilliseconds} ms`)), limitMilliseconds);
  });
  const visible = avatars.filter((avatar) => avatar.src);
  await Promise.race([Promise.all(visible.map((avatar) => avatar.ready)), late]);
}
