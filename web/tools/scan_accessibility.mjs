/**
 * Scans pages with axe-core in headless Chromium, for `cargo xtask test`.
 *
 * The only argument is a JSON object: { pages: [{ url, width, height, dark }], chromium, flags, limitMilliseconds }. Prints a JSON list of
 * violations, one string each: page, rule, place.
 */

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import process from "node:process";
import { launchChromium } from "./page.mjs";

const AXE = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

const order = JSON.parse(process.argv[2] ?? "null");
const browser = await launchChromium(order);
const violations = [];
try {
  for (const page of order.pages) {
    violations.push(...(await scan(page)));
  }
} finally {
  await browser.close();
}
process.stdout.write(`${JSON.stringify(violations)}\n`);

async function scan({ url, width, height, dark }) {
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: dark ? "dark" : "light" });
  page.setDefaultTimeout(order.limitMilliseconds);
  await page.goto(url, { waitUntil: "load" });
  await page.evaluate(async () => {
    await document.fonts.ready;
    const avatar = document.querySelector("crease-avatar");
    await avatar?.ready;
    // Contrast is measured on a picture that stands.
    avatar?.pause();
  });
  // Not as a script of the page: its policy allows none but its own.
  await page.evaluate(AXE);
  const { violations: found } = await page.evaluate(() => axe.run());
  await page.close();
  const name = `${new URL(url).pathname} at ${width} × ${height}${dark ? ", dark" : ""}`;
  return found.flatMap(({ id, help, nodes }) =>
    nodes.map(({ target }) => `${name}: ${id} (${help}): ${target.join(" ")}`),
  );
}
