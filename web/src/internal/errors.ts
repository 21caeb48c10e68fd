import type { ErrorCode, Failure } from "./protocol.js";

/** An error that knows its code and the file it is about. */
export class StageError extends Error {
  override readonly name = "StageError";
  readonly code: ErrorCode;
  readonly url: string | null;

  constructor(code: ErrorCode, message: string, url: string | null = null) {
    super(message);
    this.code = code;
    this.url = url;
  }
}

/** Whether the wasm module has panicked. What it had borrowed stays borrowed, and nothing else may be tried with it. */
export function isPanic(thrown: unknown): thrown is WebAssembly.RuntimeError {
  return thrown instanceof WebAssembly.RuntimeError;
}

/** Innermost calls that a message names. */
const CALLS = 6;

/** What is known of a panic: the functions it came through, innermost first, by the numbers that `crease_bg.symbols` has names for. */
function traceOf(panic: WebAssembly.RuntimeError): string {
  const calls = [...(panic.stack ?? "").matchAll(/wasm-function\[(\d+)\]/gu)].map(([, number]) => number);
  return calls.length > 0 ? `${panic.message} in wasm function ${calls.slice(0, CALLS).join(" < ")}` : panic.message;
}

/** Any thrown value as a failure; errors out of the wasm module carry their own code. */
export function failureOf(thrown: unknown, url: string | null): Failure {
  if (thrown instanceof StageError) {
    return { code: thrown.code, message: thrown.message, url: thrown.url ?? url };
  }
  if (isPanic(thrown)) return { code: "internal", message: traceOf(thrown), url };
  if (thrown instanceof Error) {
    const code = (thrown as Error & { code?: ErrorCode }).code;
    return { code: typeof code === "string" ? code : "internal", message: thrown.message, url };
  }
  return { code: "internal", message: String(thrown), url };
}
