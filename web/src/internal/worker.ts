import type { Command, Report } from "./protocol.js";
import { hasWebGpu, Stage } from "./stage.js";

/** The part of a worker's global scope that is used here. */
interface WorkerScope {
  onmessage: ((event: MessageEvent<Command>) => void) | null;
  postMessage(report: Report): void;
}

const scope = globalThis as unknown as WorkerScope;
const stage = new Stage((report) => scope.postMessage(report));
scope.onmessage = (event) => stage.handle(event.data);

void hasWebGpu().then((webgpu) => {
  // A worker without animation frames cannot keep time with the screen.
  scope.postMessage({ kind: "capability", webgpu: webgpu && typeof requestAnimationFrame === "function" });
});
