import { BUILD } from "../../pkg/build.js";
import { allowThreads, wasmModule } from "./module.js";
import type { Addressed, Begin, Command, Report } from "./protocol.js";
import { Stage } from "./stage.js";
import { hasWebGpu } from "./webgpu.js";

/** The part of a worker's global scope that is used here. */
interface WorkerScope {
  onmessage: ((event: MessageEvent<Begin | Addressed<Command>>) => void) | null;
  postMessage(report: Addressed<Report>): void;
}

const scope = globalThis as unknown as WorkerScope;
const stages = new Map<number, Stage>();

scope.onmessage = ({ data }) => {
  if ("threads" in data) {
    begin(data);
    return;
  }
  const { stage: number, message } = data;
  let stage = stages.get(number);
  if (!stage) {
    stage = new Stage((report) => scope.postMessage({ stage: number, message: report }));
    stages.set(number, stage);
  }
  stage.handle(message);
  if (message.kind === "close") stages.delete(number);
};

const capability = hasWebGpu().then((webgpu) => {
  // A worker without animation frames cannot keep time with the screen.
  const animationFrames = typeof requestAnimationFrame === "function";
  scope.postMessage({ stage: 0, message: { kind: "capability", build: BUILD, webgpu, animationFrames } });
});

function begin({ threads }: Begin): void {
  // The page makes them: while this worker waits for its threads it would not hear what goes wrong in them. It hears of the worker's
  // capabilities first.
  if (threads > 1) {
    allowThreads((shared) => {
      void capability.then(() => scope.postMessage({ stage: 0, message: { kind: "threads-wanted", shared } }));
    });
  }
  // Compiles beside everything else; whoever waits for it hears of a failure.
  wasmModule().catch(() => {});
}
