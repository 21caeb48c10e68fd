import type { Command, Report } from "./protocol.js";
import { hasWebGpu } from "./webgpu.js";
import { WorkerHost } from "./worker-host.js";

/** A stage, wherever it runs. */
export interface Connection {
  /** Where it runs, for curious people. */
  readonly thread: "worker" | "main";
  /** How many threads share a frame. */
  readonly threads: number;
  /** Sends a command. */
  send(command: Command): void;
  /** Gives it a canvas to draw on. */
  giveCanvas(canvas: HTMLCanvasElement): void;
  /** Frees what the stage holds; the worker goes with its last stage. */
  close(): void;
}

/** The worker that all avatars of this page share; null where there can be none. */
let host: Promise<WorkerHost | null> | null = null;

/** A stage in the page's worker, or on this thread where workers have no canvas, or no WebGPU although this thread has it. */
export async function connect(onReport: (report: Report) => void): Promise<Connection> {
  const worker = await openHost();
  if (worker) return worker.connect(onReport);
  const { Stage } = await import("./stage.js");
  const stage = new Stage(onReport);
  return {
    thread: "main",
    threads: 1,
    send: (command) => stage.handle(command),
    giveCanvas: (canvas) => stage.handle({ kind: "canvas", canvas }),
    close: () => stage.handle({ kind: "close" }),
  };
}

async function openHost(): Promise<WorkerHost | null> {
  for (;;) {
    host ??= startHost();
    const asked = host;
    try {
      const found = await asked;
      if (!found || found.usable) return found;
      // It has ended, or something broke in it: the next avatar gets another.
      if (host === asked) host = null;
    } catch (thrown) {
      if (host === asked) host = null;
      throw thrown;
    }
  }
}

async function startHost(): Promise<WorkerHost | null> {
  if (typeof Worker !== "function" || !("transferControlToOffscreen" in HTMLCanvasElement.prototype)) return null;
  const started = await WorkerHost.start();
  if (!started) return null;
  const { animationFrames, webgpu } = started.capability;
  if (animationFrames && (webgpu || !(await hasWebGpu()))) return started.host;
  started.host.end();
  return null;
}
