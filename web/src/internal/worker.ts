import { BUILD } from "../../pkg/build.js";
import { wasmModule } from "./module.js";
import type { Addressed, Command, Report } from "./protocol.js";
import { Stage } from "./stage.js";
import { hasWebGpu } from "./webgpu.js";

/** The part of a worker's global scope that is used here. */
interface WorkerScope {
  onmessage: ((event: MessageEvent<Addressed<Command>>) => void) | null;
  postMessage(report: Addressed<Report>): void;
}

const scope = globalThis as unknown as WorkerScope;
const stages = new Map<number, Stage>();

scope.onmessage = ({ data: { stage: number, message } }) => {
  let stage = stages.get(number);
  if (!stage) {
    stage = new Stage((report) => scope.postMessage({ stage: number, message: report }));
    stages.set(number, stage);
  }
  stage.handle(message);
  if (message.kind === "close") stages.delete(number);
};

// Compiles beside everything else; whoever waits for it hears of a failure.
wasmModule().catch(() => {});

void hasWebGpu().then((webgpu) => {
  // A worker without animation frames cannot keep time with the screen.
  const animationFrames = typeof requestAnimationFrame === "function";
  scope.postMessage({ stage: 0, message: { kind: "capability", build: BUILD, webgpu, animationFrames } });
});
