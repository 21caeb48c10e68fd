import initialise, { type InitOutput } from "../../pkg/crease.js";

let loading: Promise<InitOutput> | undefined;

/** The wasm module, compiled while it arrives, once for a thread. */
export function wasmModule(): Promise<InitOutput> {
  loading ??= initialise();
  return loading;
}
