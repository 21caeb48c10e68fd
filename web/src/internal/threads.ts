/** What the threads of a module share. */
export interface Shared {
  readonly module: WebAssembly.Module;
  readonly memory: WebAssembly.Memory;
}

/** Has workers become threads of a module. */
export type ThreadMaker = (shared: Shared) => void;

/** More gain little: some of a frame's work is one thread's. */
const LIMIT = 4;

/**
 * How many threads may share a frame here: one, unless the page is isolated from others, so that its workers may share memory. One processor
 * stays with the page and what draws it.
 */
export function mostThreads(): number {
  return globalThis.crossOriginIsolated ? Math.max(Math.min(navigator.hardwareConcurrency - 1, LIMIT), 1) : 1;
}
