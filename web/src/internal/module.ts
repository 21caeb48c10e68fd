import { MODULE_URL } from "../../pkg/build.js";
import initialise, { type InitOutput } from "../../pkg/crease.js";
import { errorOfBuild } from "./build.js";
import { StageError } from "./errors.js";
import { fetchFile } from "./fetch.js";

let loading: Promise<InitOutput> | undefined;

/** The wasm module, compiled while it arrives, once for a thread. After a failure whoever asks next has it tried again. */
export function wasmModule(): Promise<InitOutput> {
  loading ??= load().catch((thrown) => {
    loading = undefined;
    throw thrown;
  });
  return loading;
}

async function load(): Promise<InitOutput> {
  const url = MODULE_URL.href;
  // Some browsers switch it off where a person wants to be safer.
  if (typeof WebAssembly !== "object") throw new StageError("unsupported", "expected WebAssembly, found none");
  const module = await fetchFile(url, {}, compile);
  const [section] = WebAssembly.Module.customSections(module, "crease-build");
  // Of another build it would not fit the scripts: it must not even start.
  const error = errorOfBuild(section && new TextDecoder().decode(section), url);
  if (error) throw error;
  return initialise({ module_or_path: module });
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
