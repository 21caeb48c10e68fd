/**
 * Bundles dist/ into lib/: one flat folder that any server can host as it is. The workers and the wasm modules lie beside the scripts, where
 * `new URL("./…", import.meta.url)` finds them; a bundler finds them by the same words.
 */

import { copyFile, rm } from "node:fs/promises";
import { build } from "esbuild";

const folder = "lib";

await rm(folder, { recursive: true, force: true });
await build({
  entryPoints: {
    "crease-avatar": "dist/public/crease-avatar.js",
    worker: "dist/internal/worker.js",
    thread: "dist/internal/thread.js",
  },
  outdir: folder,
  chunkNames: "[name]-[hash]",
  bundle: true,
  splitting: true,
  format: "esm",
  target: "es2022",
  minify: true,
  sourcemap: true,
  logLevel: "warning",
});
for (const name of ["crease_bg", "crease_threads_bg"]) {
  for (const ending of ["wasm", "symbols"]) await copyFile(`pkg/${name}.${ending}`, `${folder}/${name}.${ending}`);
}
