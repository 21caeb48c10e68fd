import { hasWebGpu } from "./connection.js";
import { wasmModule } from "./module.js";
import type { Command, Report } from "./protocol.js";
import { Stage } from "./stage.js";

/** The part of a worker's global scope that is used here. */
interface WorkerScope {
  onmessage: ((event: MessageEvent<Command>) => void) | null;
  postMessage(report: Report): void;
}

const scope = globalThis as unknown as WorkerScope;
const stage = new Stage((report) => scope.postMessage(report));
scope.onmessage = (event) => stage.handle(event.data);

// Compiles beside everything else; whoever waits for it hears of a failure.
wasmModule().catch(() => {});

void hasWebGpu().then((webgpu) => {
  // A worker without animation frames cannot keep time with the screen.
  const animationFrames = typeof requestAnimationFrame === "function";
  scope.postMessage({ kind: "capability", webgpu, animationFrames });
});
