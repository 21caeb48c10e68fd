import { MODULE_URL, THREADS_MODULE_URL } from "../../pkg/build.js";
import initialise, { PictureLayout, Viewer, WebGpuPainter } from "../../pkg/crease.js";
import { errorOfBuild } from "./build.js";
import { StageError } from "./errors.js";
import { fetchFile } from "./fetch.js";
import type { ThreadMaker } from "./threads.js";

/** What the wasm module has, in either form. */
export interface Runtime {
  readonly Viewer: typeof Viewer;
  readonly WebGpuPainter: typeof WebGpuPainter;
  readonly PictureLayout: typeof PictureLayout;
  readonly memory: WebAssembly.Memory;
}

let makeThreads: ThreadMaker | null = null;
let loading: Promise<Runtime> | undefined;

/** The module may run on several threads, which `maker` makes: to be said before anyone asks for it. */
export function allowThreads(maker: ThreadMaker): void {
  makeThreads = maker;
}

/** The wasm module, compiled while it arrives, once for a thread. After a failure whoever asks next has it tried again. */
export function wasmModule(): Promise<Runtime> {
  loading ??= load().catch((thrown) => {
    loading = undefined;
    throw thrown;
  });
  return loading;
}

async function load(): Promise<Runtime> {
  if (makeThreads) {
    try {
      return await loadForThreads(makeThreads);
    } catch (thrown) {
      const reason = thrown instanceof Error ? thrown.message : String(thrown);
      console.warn(`crease-avatar: threads: ${reason}. Using one thread instead.`);
    }
  }
  const { memory } = await initialise({ module_or_path: await compiledModule(MODULE_URL.href) });
  return { Viewer, WebGpuPainter, PictureLayout, memory };
}

async function loadForThreads(make: ThreadMaker): Promise<Runtime> {
  const [module, bindings] = await Promise.all([
    compiledModule(THREADS_MODULE_URL.href),
    import("../../pkg/crease_threads.js"),
  ]);
  const { default: initialise, Viewer, WebGpuPainter, PictureLayout } = bindings;
  const { memory } = await initialise({ module_or_path: module });
  make({ module, memory });
  return { Viewer, WebGpuPainter, PictureLayout, memory };
}

async function compiledModule(url: string): Promise<WebAssembly.Module> {
  // Some browsers switch it off where a person wants to be safer.
  if (typeof WebAssembly !== "object") throw new StageError("unsupported", "expected WebAssembly, found none");
  const module = await fetchFile(url, {}, compile);
  const [section] = WebAssembly.Module.customSections(module, "crease-build");
  // Of another build it would not fit the scripts: it must not even start.
  const error = errorOfBuild(section && new TextDecoder().decode(section), url);
  if (error) throw error;
  return module;
}

async function compile(response: Response): Promise<WebAssembly.Module> {
  try {
    // Browsers compile a file while it arrives only if the server names its type.
    if (response.headers.get("content-type") === "application/wasm")
      return await WebAssembly.compileStreaming(response);
    return await WebAssembly.compile(await response.arrayBuffer());
  } catch (thrown) {
    if (!(thrown instanceof WebAssembly.CompileError)) throw thrown;
    const { message } = thrown;
    throw new StageError(
      "unsupported",
      `${response.url}: expected a module that this browser compiles, found ${message}`,
    );
  }
}
