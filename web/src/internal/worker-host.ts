import { BUILD } from "../../pkg/build.js";
import { errorOfBuild } from "./build.js";
import type { Connection } from "./connection.js";
import type { Addressed, Begin, Command, Report, ThreadReport, ThreadStart } from "./protocol.js";
import { mostThreads, type Shared } from "./threads.js";

/** Milliseconds that a worker without stages lives on: it frees the GPU, and an element that comes back finds it. */
const FAREWELL = 500;

/** What a worker can do. */
type Capability = Report & { readonly kind: "capability" };

/** A worker with any number of stages: one wasm module and one device for all of them. */
export class WorkerHost {
  readonly #worker: Worker;
  readonly #threads: Worker[] = [];
  readonly #listeners = new Map<number, (report: Report) => void>();
  #nextStage = 1;
  #farewell: ReturnType<typeof setTimeout> | undefined;
  #usable = true;
  /** Threads that share a frame, the worker's own among them. */
  #threadCount = 1;

  private constructor(worker: Worker) {
    this.#worker = worker;
    worker.onmessage = ({ data }: MessageEvent<Addressed<Report>>) => this.#hear(data);
    worker.onerror = (event) => this.#break(event);
  }

  /** A worker, and what it can do; null where it does not start. Throws where it is of another build. */
  static async start(): Promise<{ host: WorkerHost; capability: Capability } | null> {
    let worker: Worker;
    try {
      worker = newWorker("worker.js");
    } catch {
      return null;
    }
    worker.postMessage({ threads: mostThreads() } satisfies Begin);
    const capability = await new Promise<Capability | null>((resolve) => {
      worker.onmessage = ({ data }: MessageEvent<Addressed<Report>>) => {
        if (data.message.kind === "capability") resolve(data.message);
      };
      worker.onerror = (event) => {
        event.preventDefault();
        resolve(null);
      };
    });
    const error = capability && errorOfBuild(capability.build, besideThis("worker.js"));
    if (capability && !error) return { host: new WorkerHost(worker), capability };
    worker.terminate();
    if (error) throw error;
    return null;
  }

  /** Whether another stage may be opened here. */
  get usable(): boolean {
    return this.#usable;
  }

  #hear({ stage, message }: Addressed<Report>): void {
    // A wasm module that has panicked is not to be trusted with another avatar.
    if (message.kind === "failed" && message.failure.code === "internal") this.#usable = false;
    if (message.kind === "threads-wanted") this.#makeThreads(message.shared);
    this.#listeners.get(stage)?.(message);
  }

  /** Something broke outside of any stage: none of them can go on. */
  #break(event: ErrorEvent): void {
    event.preventDefault();
    this.end();
    const failure = { code: "internal", message: event.message, url: event.filename || null } as const;
    for (const listener of [...this.#listeners.values()]) listener({ kind: "failed", failure, fatal: true });
  }

  /** Frames wait for none of them: one that does not start is done without. */
  #makeThreads(shared: Shared): void {
    for (let wanted = mostThreads() - 1; wanted > 0; wanted -= 1) {
      let thread: Worker;
      try {
        thread = newWorker("thread.js");
      } catch {
        return;
      }
      this.#threads.push(thread);
      thread.onmessage = (_: MessageEvent<ThreadReport>) => {
        this.#threadCount += 1;
        // The worker would wait for ever for what this one leaves undone.
        thread.onerror = (event) => this.#break(event);
      };
      thread.onerror = (event) => event.preventDefault();
      thread.postMessage({ build: BUILD, ...shared } satisfies ThreadStart);
    }
  }

  /** Opens a stage. */
  connect(onReport: (report: Report) => void): Connection {
    clearTimeout(this.#farewell);
    const stage = this.#nextStage;
    this.#nextStage += 1;
    this.#listeners.set(stage, onReport);
    const threadCount = (): number => this.#threadCount;
    const send = (message: Command, transfer: Transferable[] = []): void =>
      this.#worker.postMessage({ stage, message } satisfies Addressed<Command>, transfer);
    return {
      thread: "worker",
      get threads() {
        return threadCount();
      },
      send,
      giveCanvas: (element) => {
        const canvas = element.transferControlToOffscreen();
        send({ kind: "canvas", canvas }, [canvas]);
      },
      close: () => {
        if (!this.#listeners.delete(stage)) return;
        send({ kind: "close" });
        if (this.#listeners.size === 0) this.#farewell = setTimeout(() => this.end(), FAREWELL);
      },
    };
  }

  /** Ends the worker and its threads. */
  end(): void {
    this.#usable = false;
    for (const worker of [this.#worker, ...this.#threads]) worker.terminate();
  }
}

/** Address of a script beside this one. Not by `new URL`: bundlers would take it for another asset. */
function besideThis(name: string): string {
  return import.meta.url.replace(/[^/]*$/u, name);
}

/** Browsers start workers from the page's own origin only: a script from elsewhere is imported by one line that is the page's. */
function newWorker(script: "worker.js" | "thread.js"): Worker {
  const { origin, protocol } = new URL(import.meta.url);
  // A bundler that puts the worker beside the page leaves the address of the source here, which is no address of the web.
  if (origin === location.origin || !protocol.startsWith("http")) {
    // Bundlers know a worker by these very words.
    return script === "worker.js"
      ? new Worker(new URL("./worker.js", import.meta.url), { type: "module" })
      : new Worker(new URL("./thread.js", import.meta.url), { type: "module" });
  }
  const imported = JSON.stringify(besideThis(script));
  const line = URL.createObjectURL(new Blob([`import ${imported};`], { type: "text/javascript" }));
  const worker = new Worker(line, { type: "module" });
  worker.addEventListener("message", () => URL.revokeObjectURL(line), { once: true });
  return worker;
}
