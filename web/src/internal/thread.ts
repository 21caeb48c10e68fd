import { BUILD } from "../../pkg/build.js";
import { initSync, joinThreads } from "../../pkg/crease_threads.js";
import type { ThreadReport, ThreadStart } from "./protocol.js";

/** Bytes; frames go no deeper than a few calls. */
const STACK = 1 << 18;

/** The part of a worker's global scope that is used here. */
interface ThreadScope {
  onmessage: ((event: MessageEvent<ThreadStart>) => void) | null;
  postMessage(report: ThreadReport): void;
}

const scope = globalThis as unknown as ThreadScope;

// Of another build it would not fit the module: then the frames go on without it.
scope.onmessage = ({ data: { build, module, memory } }) => {
  if (build !== BUILD) return;
  initSync({ module, memory, thread_stack_size: STACK });
  scope.postMessage("running");
  // Takes its part of every frame from now on, and does not come back.
  joinThreads();
};
