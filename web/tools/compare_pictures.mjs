/**
 * Compares two PNG files as an eye would: colours by their perceived distance, edges that are only smoothed otherwise left out.
 *
 * Arguments: the two files. Prints one JSON object: { different, pixels }.
 */

import { readFile } from "node:fs/promises";
import process from "node:process";
import pixelmatch from "pixelmatch";
import { PNG } from "pngjs";

/** Of 0 to 1; pixelmatch's own default. */
const THRESHOLD = 0.1;

const [first, second] = await Promise.all(
  process.argv.slice(2, 4).map(async (file) => PNG.sync.read(await readFile(file))),
);
const { width, height } = first;
const same = second.width === width && second.height === height;
const pixels = width * height;
const different = same ? pixelmatch(first.data, second.data, null, width, height, { threshold: THRESHOLD }) : pixels;
process.stdout.write(`${JSON.stringify({ different, pixels })}\n`);
