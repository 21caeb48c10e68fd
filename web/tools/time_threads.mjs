/**
 * What a frame costs on one thread and on several, for `cargo xtask bench`: the module in Node, where nothing is drawn beside it.
 *
 * The argument is a JSON object: { package, avatar, motion, threads }, paths of the built bindings' folder and of files. Prints a JSON object of
 * median milliseconds.
 */

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import { pathToFileURL } from "node:url";
import { isMainThread, Worker, workerData } from "node:worker_threads";

/** Pictures a second, of the motion and of the clock. */
const RATE = 60;

/** Frames until everything is compiled and has its size, and frames that are measured. */
const BEFORE = 60;
const MEASURED = 240;

/** Until the workers are there. */
const START_MILLISECONDS = 1000;

const bindings = (folder, name) => import(pathToFileURL(join(folder, `${name}.js`)));

if (isMainThread) {
  const order = JSON.parse(process.argv[2] ?? "null");
  const single = await start(order, "crease");
  const shared = await start(order, "crease_threads");
  for (let made = 1; made < order.threads; made += 1)
    new Worker(new URL(import.meta.url), { workerData: shared.share });
  await pause(START_MILLISECONDS);
  const times = { frame_ms_wasm_alone: [], frame_ms_wasm_threads: [] };
  // In turns: what else the machine does meets both.
  for (let frame = 0; frame < BEFORE + MEASURED; frame += 1) {
    const milliseconds = [single, shared].map(({ viewer }) => timeOf(viewer, frame));
    if (frame < BEFORE) continue;
    for (const [index, list] of Object.values(times).entries()) list.push(milliseconds[index]);
  }
  const medians = Object.entries(times).map(([name, list]) => [name, median(list)]);
  console.log(JSON.stringify({ threads: order.threads, ...Object.fromEntries(medians) }));
  process.exit();
} else {
  const { initSync, joinThreads } = await bindings(workerData.folder, "crease_threads");
  initSync({ module: workerData.module, memory: workerData.memory, thread_stack_size: 1 << 18 });
  joinThreads();
}

/** The avatar at its finest, playing. */
async function start({ package: folder, avatar, motion }, name) {
  const { initSync, Viewer } = await bindings(folder, name);
  const module = new WebAssembly.Module(readFileSync(join(folder, `${name}_bg.wasm`)));
  const { memory } = initSync({ module });
  const viewer = new Viewer(readFileSync(avatar), "avatar.glb");
  viewer.setQuality("high");
  viewer.prepareDetail();
  viewer.beginMotions();
  viewer.readMotion(readFileSync(motion), "motion.pkl", RATE);
  viewer.playMotions();
  viewer.setLoop(true);
  viewer.play();
  return { viewer, share: { folder, module, memory } };
}

function timeOf(viewer, frame) {
  viewer.advance((1000 * (frame + 1)) / RATE, false);
  viewer.drawn(undefined, 0);
  return viewer.poseMilliseconds;
}

function median(numbers) {
  return [...numbers].sort((a, b) => a - b)[numbers.length >> 1];
}
