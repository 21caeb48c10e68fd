import { BUILD } from "../../pkg/build.js";
import type { ThreadReport, ThreadStart } from "./protocol.js";

/** Bytes; frames go no deeper than a few calls. */
const STACK = 1 << 18;

/** The part of a worker's global scope that is used here. */
interface ThreadScope {
  onmessage: ((event: MessageEvent<ThreadStart>) => void) | null;
  postMessage(report: ThreadReport): void;
}

const scope = globalThis as unknown as ThreadScope;

scope.onmessage = ({ data }) => {
  // A promise that fails is told to nobody, an error is told to the page.
  takePart(data).catch(reportError);
};

async function takePart({ build, module, memory }: ThreadStart): Promise<void> {
  // Of another build it would not fit the module: then the frames go on without it.
  if (build !== BUILD) return;
  // As the worker loads it: bundlers then have it once, in a file that other pages do not load.
  const { initSync, joinThreads } = await import("../../pkg/crease_threads.js");
  initSync({ module, memory, thread_stack_size: STACK });
  scope.postMessage("running");
  // Takes its part of every frame from now on, and does not come back.
  joinThreads();
}
