/**
 * Draws the pictures of the demo's catalogue in headless Chromium, for `cargo xtask pictures`: one for each motion, and a poster for each avatar.
 *
 * The only argument is a JSON object: { url, folder, chromium, flags, limitMilliseconds }, where url is that of tests/pages/picture.html on a server of
 * the whole repository's pages. Prints a JSON list of { file, bytes }.
 */

import { mkdir, writeFile } from "node:fs/promises";
import path from "node:path";
import process from "node:process";
import { AVATARS, MOTIONS } from "../../demo/catalogue.js";
import { launchChromium } from "./page.mjs";

/** On the shelf; twice as many pixels as it takes there. */
const CARD = {
  width: 192,
  height: 144,
  follow: "root",
  "camera-target": "0m 0.9m 0m",
  "camera-orbit": "18deg 84deg 3.4m",
  shadow: 0.5,
};
/** As wide as a window: the camera's distance follows from the shape. */
const POSTER = { width: 1120, height: 620 };

const order = JSON.parse(process.argv[2] ?? "null");
await mkdir(order.folder, { recursive: true });
const [anybody] = AVATARS;
const jobs = [
  ...MOTIONS.map((motion) => ({ name: motion.id, avatar: anybody, motion, time: motion.still, about: CARD })),
  ...AVATARS.map((avatar) => ({ name: avatar.id, avatar, motion: MOTIONS[0], time: 0, about: POSTER })),
];
const browser = await launchChromium(order);
const made = [];
try {
  for (const job of jobs) made.push(await draw(job));
} finally {
  await browser.close();
}
process.stdout.write(`${JSON.stringify(made)}\n`);

async function draw({ name, avatar, motion, time, about }) {
  const url = new URL(order.url);
  const attributes = {
    src: `/${avatar.src}`,
    motion: `/${motion.src}`,
    fps: motion.fps,
    background: "transparent",
    theme: "light",
  };
  for (const [key, value] of Object.entries({ ...attributes, ...about, time })) url.searchParams.set(key, value);
  const page = await browser.newPage({ viewport: { width: about.width, height: about.height }, deviceScaleFactor: 1 });
  page.setDefaultTimeout(order.limitMilliseconds);
  await page.goto(url.href, { waitUntil: "load" });
  const bytes = Buffer.from(await page.evaluate(() => globalThis.picture()), "base64");
  await page.close();
  const file = path.join(order.folder, `${name}.webp`);
  await writeFile(file, bytes);
  return { file, bytes: bytes.length };
}
