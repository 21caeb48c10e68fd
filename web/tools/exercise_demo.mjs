/**
 * Uses the demo page as a visitor does, in headless Chromium, for `cargo xtask demo`.
 *
 * The only argument is a JSON object: { url, chromium, flags, limitMilliseconds, folder, avatar, motion }: a small avatar and a small motion to drop.
 * Screenshots go into `folder`. Prints one JSON object: { problems, screenshots }.
 */

import assert from "node:assert/strict";
import { readFile, stat } from "node:fs/promises";
import path from "node:path";
import process from "node:process";
import { setTimeout as sleep } from "node:timers/promises";
import { collectProblems, firstLine, launchChromium } from "./page.mjs";

const DESKTOP = { width: 1280, height: 800 };
const PHONE = { width: 390, height: 844 };
/** Fades and the like. */
const CALM_MILLISECONDS = 700;

const order = JSON.parse(process.argv[2] ?? "null");
const result = { problems: [], screenshots: [] };
const browser = await launchChromium(order);

const steps = [
  firstPaint,
  plays,
  motionsAndTime,
  wrinkles,
  comparison,
  ownFiles,
  badFiles,
  saves,
  share,
  embed,
  dark,
  phone,
];
try {
  const context = await browser.newContext({ viewport: DESKTOP, permissions: ["clipboard-read", "clipboard-write"] });
  context.setDefaultTimeout(order.limitMilliseconds);
  await context.addInitScript(keepMessages);
  const page = await context.newPage();
  collectProblems(page, result.problems);
  for (const step of steps) {
    try {
      await step(page, context);
    } catch (error) {
      result.problems.push(`${step.name}: ${firstLine(error)}`);
      break;
    }
  }
} finally {
  await browser.close();
}
process.stdout.write(`${JSON.stringify(result)}\n`);

/** The page is there before the wasm module is. */
async function firstPaint(page) {
  let release;
  const held = new Promise((resolve) => {
    release = resolve;
  });
  await page.route("**/*.wasm", async (route) => {
    await held;
    await route.continue();
  });
  await page.goto(order.url, { waitUntil: "domcontentloaded" });
  await page.locator("#motions .card").first().waitFor();
  await page.waitForFunction(() => [...document.images].every((image) => image.complete && image.naturalWidth > 0));
  assert.equal(await page.evaluate(() => avatar.loaded), false);
  await screenshot(page, "first-paint");
  release();
}

async function plays(page) {
  await ready(page);
  await page.waitForFunction(() => avatar.statistics.frames > 3 && !avatar.paused);
  assert.match(await page.locator("#figures").textContent(), /vertices · Web/u);
  await screenshot(page, "desktop");
}

async function motionsAndTime(page) {
  await page.locator("#motions .card", { hasText: "Spin kick" }).click();
  await page.waitForFunction(() => avatar.motion.includes("spinkick") && avatar.duration > 0);
  await page.locator("#play").click();
  await page.waitForFunction(() => avatar.paused);
  await page.locator("#time").fill("0.5");
  await page.waitForFunction(() => Math.abs(avatar.currentTime - 0.5) < 1e-6 && !avatar.seeking);
  assert.equal(await page.locator("#now").textContent(), "0:00.5");
}

async function wrinkles(page) {
  await page.locator("#detail").fill("0");
  assert.equal(await page.evaluate(() => avatar.detail), 0);
  assert.equal(await page.locator("#detail-value").textContent(), "none");
  await page.locator("#detail").fill("1");
  await page.locator("#views label", { hasText: "Normals" }).click();
  assert.equal(await page.evaluate(() => avatar.view), "normals");
  await screenshot(page, "normals");
  await page.locator("#views label", { hasText: "Detailed" }).click();
}

async function comparison(page) {
  await page.locator("#compare").click();
  await page.waitForFunction(() => document.querySelector(".before")?.loaded);
  await page.waitForFunction(() => document.querySelector(".before").currentTime === avatar.currentTime);
  assert.equal(await page.evaluate(() => document.querySelector(".before").view), "base");
  await screenshot(page, "compare");
  await page.locator("#compare").click();
  assert.equal(await page.locator("crease-avatar").count(), 1);
}

/** One file chosen, one dropped. */
async function ownFiles(page) {
  await page.locator("#file").setInputFiles(order.avatar);
  await page.waitForFunction(() => avatar.src.startsWith("blob:"));
  await ready(page);
  const name = path.basename(order.motion);
  const base64 = (await readFile(order.motion)).toString("base64");
  await page.evaluate(dropFile, { name, base64 });
  await page.waitForFunction((name) => document.querySelector("#caption").textContent.includes(name), name);
  await page.waitForFunction(() => avatar.motion.startsWith("blob:") && avatar.duration > 0 && avatar.error === null);
}

/** What is wrong is said, and what was there before comes back. */
async function badFiles(page) {
  const before = await page.evaluate(() => avatar.src);
  await page.evaluate(dropFile, { name: "notes.txt", base64: "AAAA" });
  await message(page, /notes\.txt: expected an avatar \(\.glb\) or a motion/u);
  await page.evaluate(dropFile, { name: "broken.glb", base64: "AAAA" });
  await message(page, /broken\.glb/u);
  await page.waitForFunction((before) => avatar.src === before && avatar.loaded, before);
  await page.evaluate(dropFile, { name: "broken.npz", base64: "AAAA" });
  await message(page, /broken\.npz/u);
  await screenshot(page, "error");
}

async function saves(page) {
  for (const [id, least] of [
    ["picture", 2_000],
    ["mesh", 20_000],
    ["film", 1_000],
  ]) {
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator(`#${id}`).click()]);
    const { size } = await stat(await download.path());
    assert.ok(size > least, `${download.suggestedFilename()}: expected more than ${least} bytes, found ${size}`);
  }
}

/** Whoever follows the link sees the same moment from the same place. */
async function share(page, context) {
  await page.locator("#share").click();
  await message(page, /file of your own/u);
  await page.goto(`${order.url}?motion=spin&time=0.75&paused=&orbit=${encodeURIComponent("0.5rad 1.4rad 3m")}`);
  await ready(page);
  await page.locator("#share").click();
  await message(page, /Link copied/u);
  const link = await page.evaluate(() => navigator.clipboard.readText());
  const other = await context.newPage();
  await other.goto(link);
  await ready(other);
  // The camera comes to rest.
  await sleep(CALM_MILLISECONDS);
  const state = () =>
    [avatar.motion, avatar.currentTime.toFixed(3), avatar.paused, `${avatar.getCameraOrbit()}`].join(" ");
  const [sent, seen] = [await page.evaluate(state), await other.evaluate(state)];
  await other.close();
  assert.equal(seen, sent, `sent ${sent}, seen ${seen}`);
  assert.match(sent, /spin\.pkl 0\.750 true 0\.5/u);
}

async function embed(page) {
  await page.locator("#embed").click();
  const code = await page.locator("#embed-code").textContent();
  assert.match(code, /<script type="module"[\s\S]*<crease-avatar[\s\S]*motion="http[^"]*spin\.pkl"/u);
  await screenshot(page, "embed");
  await page.locator("#embed-copy").click();
  assert.equal(await page.evaluate(() => navigator.clipboard.readText()), code);
}

async function dark(page) {
  await page.locator("#theme").click();
  assert.equal(await page.evaluate(() => avatar.theme), "dark");
  await screenshot(page, "dark");
}

async function phone(page) {
  await page.setViewportSize(PHONE);
  await page.goto(order.url);
  await ready(page);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "the page scrolls sideways");
  await screenshot(page, "phone");
  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  await screenshot(page, "phone-below");
}

async function ready(page) {
  await page.evaluate(() => customElements.whenDefined("crease-avatar").then(() => avatar.ready));
}

async function message(page, pattern) {
  try {
    await page.waitForFunction((pattern) => messages.some((text) => pattern.test(text)), pattern);
  } catch (error) {
    const seen = await page.evaluate(() => messages);
    throw new Error(`expected a message like ${pattern}, seen ${JSON.stringify(seen)}: ${firstLine(error)}`);
  }
}

/** Runs in each page before its scripts: keeps every message that is shown. On a busy machine one may be over before two pictures are drawn. */
function keepMessages() {
  window.messages = [];
  new MutationObserver(() => {
    const text = document.querySelector("#toast.shown")?.textContent;
    if (text && text !== messages.at(-1)) messages.push(text);
  }).observe(document, { subtree: true, childList: true, attributes: true, attributeFilter: ["class"] });
}

async function screenshot(page, name) {
  await sleep(CALM_MILLISECONDS);
  const file = path.join(order.folder, `${name}.png`);
  await page.screenshot({ path: file });
  result.screenshots.push(file);
}

/** Runs in the page: drops a file on it. */
function dropFile({ name, base64 }) {
  const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([bytes], name));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
}
