import type { Command, Report } from "./protocol.js";

/** A stage, wherever it runs. */
export interface Connection {
  /** Where it runs, for curious people. */
  readonly thread: "worker" | "main";
  /** Sends a command. */
  send(command: Command): void;
  /** Gives it a canvas to draw on. */
  giveCanvas(canvas: HTMLCanvasElement): void;
  /** Frees the GPU and the worker. */
  close(): void;
}

/** Milliseconds that a worker has to free the GPU before it is ended. */
const FAREWELL = 500;

/** Whether a thread has WebGPU: asked here, and of the worker by itself. */
export async function hasWebGpu(): Promise<boolean> {
  const { gpu } = navigator as Navigator & { gpu?: { requestAdapter(): Promise<unknown> } };
  return (await gpu?.requestAdapter().catch(() => null)) != null;
}

/** A stage in a worker, or on this thread where workers have no canvas, or no WebGPU although this thread has it. */
export async function connect(onReport: (report: Report) => void): Promise<Connection> {
  const worker = await connectWorker(onReport);
  if (worker) return worker;
  const { Stage } = await import("./stage.js");
  const stage = new Stage(onReport);
  return {
    thread: "main",
    send: (command) => stage.handle(command),
    giveCanvas: (canvas) => stage.handle({ kind: "canvas", canvas }),
    close: () => stage.handle({ kind: "close" }),
  };
}

async function connectWorker(onReport: (report: Report) => void): Promise<Connection | null> {
  if (typeof Worker !== "function" || !("transferControlToOffscreen" in HTMLCanvasElement.prototype)) return null;
  let worker: Worker;
  try {
    worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  } catch {
    return null;
  }
  const capability = await new Promise<(Report & { kind: "capability" }) | null>((resolve) => {
    worker.onmessage = (event: MessageEvent<Report>) => {
      if (event.data.kind === "capability") resolve(event.data);
    };
    worker.onerror = (event) => {
      event.preventDefault();
      resolve(null);
    };
  });
  if (!capability?.animationFrames || (!capability.webgpu && (await hasWebGpu()))) {
    worker.terminate();
    return null;
  }
  worker.onmessage = (event: MessageEvent<Report>) => onReport(event.data);
  worker.onerror = (event) => {
    event.preventDefault();
    const failure = { code: "internal", message: event.message, url: event.filename || null } as const;
    onReport({ kind: "failed", failure, fatal: true });
  };
  return {
    thread: "worker",
    send: (command) => worker.postMessage(command),
    giveCanvas: (element) => {
      const canvas = element.transferControlToOffscreen();
      worker.postMessage({ kind: "canvas", canvas } satisfies Command, [canvas]);
    },
    close: () => {
      worker.onmessage = null;
      worker.postMessage({ kind: "close" } satisfies Command);
      setTimeout(() => worker.terminate(), FAREWELL);
    },
  };
}
