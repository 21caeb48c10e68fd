import { StageError } from "./fetch.js";
import type { Command, Report } from "./protocol.js";

/** A stage, wherever it runs. */
export interface Connection {
  /** Where it runs, for curious people. */
  readonly thread: "worker" | "main";
  /** Sends a command. */
  send(command: Command): void;
  /** Opens the avatar on `canvas`. */
  open(canvas: HTMLCanvasElement, command: Omit<Command & { kind: "open" }, "canvas" | "kind">): void;
  /** Frees the GPU and the worker. */
  close(): void;
}

/** Milliseconds that a worker has to free the GPU before it is ended. */
const FAREWELL = 500;

/**
 * A stage in a worker, or on this thread where workers have no WebGPU or no canvas. Throws `unsupported` where there is no WebGPU at all.
 */
export async function connect(onReport: (report: Report) => void): Promise<Connection> {
  const worker = await connectWorker(onReport);
  if (worker) return worker;
  const { hasWebGpu, Stage } = await import("./stage.js");
  if (!(await hasWebGpu())) {
    throw new StageError("unsupported", reasonWithoutWebGpu());
  }
  const stage = new Stage(onReport);
  return {
    thread: "main",
    send: (command) => stage.handle(command),
    open: (canvas, command) => stage.handle({ kind: "open", canvas, ...command }),
    close: () => stage.handle({ kind: "close" }),
  };
}

function reasonWithoutWebGpu(): string {
  if (!("gpu" in navigator)) {
    return isSecureContext
      ? "This browser has no WebGPU, which draws the figure."
      : "WebGPU, which draws the figure, needs a page served over HTTPS or from localhost.";
  }
  return "WebGPU, which draws the figure, found no usable graphics adapter on this machine.";
}

async function connectWorker(onReport: (report: Report) => void): Promise<Connection | null> {
  if (typeof Worker !== "function" || !("transferControlToOffscreen" in HTMLCanvasElement.prototype)) return null;
  let worker: Worker;
  try {
    worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  } catch {
    return null;
  }
  const capable = await new Promise<boolean>((resolve) => {
    worker.onmessage = (event: MessageEvent<Report>) => {
      if (event.data.kind === "capability") resolve(event.data.webgpu);
    };
    worker.onerror = (event) => {
      event.preventDefault();
      resolve(false);
    };
  });
  if (!capable) {
    worker.terminate();
    return null;
  }
  worker.onmessage = (event: MessageEvent<Report>) => onReport(event.data);
  worker.onerror = (event) => {
    event.preventDefault();
    onReport({ kind: "failed", failure: { code: "internal", message: event.message, url: event.filename || null } });
  };
  return {
    thread: "worker",
    send: (command) => worker.postMessage(command),
    open: (canvas, command) => {
      const offscreen = canvas.transferControlToOffscreen();
      worker.postMessage({ kind: "open", canvas: offscreen, ...command } satisfies Command, [offscreen]);
    },
    close: () => {
      worker.onmessage = null;
      worker.postMessage({ kind: "close" } satisfies Command);
      setTimeout(() => worker.terminate(), FAREWELL);
    },
  };
}
