import type { Viewer } from "../../pkg/crease.js";
import { candidates, type Opened, once, openFirst, reasonForNext } from "./backend.js";
import { isPanic, StageError } from "./errors.js";
import { wasmModule } from "./module.js";
import { openPainter, type Painter } from "./painter.js";
import type { Backend, BackendChoice, Canvas, Failure } from "./protocol.js";

/** More losses than this within the time below, and the next backend is tried. */
const MOST_LOSSES = 3;
const LOSS_WINDOW_MILLISECONDS = 30_000;

const MOST_RETRIES = 5;
const RETRY_MILLISECONDS = 200;

const tell = once((message) => console.warn(message));

/** What a screen needs from its stage. */
export interface ScreenHost {
  /** Asks the page for a new canvas. */
  askForCanvas(): void;
  /** The avatar, once it is there. */
  viewer(): Viewer | null;
  /** Gives a new painter the figure and its texture. */
  prepare(painter: Painter, viewer: Viewer): Promise<void>;
  /** A painter is at work. */
  opened(backend: Backend): void;
}

/** The painter at work: chosen, fallen back from, rebuilt after a loss. One canvas serves one painter. */
export class Screen {
  readonly #host: ScreenHost;
  readonly #losses: number[] = [];
  #giveCanvas: ((canvas: Canvas) => void) | null = null;
  #opened: Opened<Painter> | null = null;
  #canvas: Canvas | null = null;
  #size: { width: number; height: number } | null = null;
  #share = 1;
  /** What was asked for last: a backend that was demanded by name is opened also where it is no gain. */
  #choice: BackendChoice = "auto";
  /** Counts attempts: a newer one makes an older one void. */
  #attempt = 0;
  #closed = false;

  constructor(host: ScreenHost) {
    this.#host = host;
  }

  /** The painter, unless one is being opened. */
  get painter(): Painter | null {
    return this.#opened?.value ?? null;
  }

  /** What the painter draws on. */
  get canvas(): Canvas | null {
    return this.#canvas;
  }

  /** The backend at work. */
  get backend(): Backend | null {
    return this.#opened?.backend ?? null;
  }

  /** Opens a painter of the backend chosen, or of the next one that works. `avatar` is waited for before the figure is prepared. */
  async open(choice: BackendChoice | readonly Backend[], avatar: Promise<unknown>): Promise<void> {
    this.#attempt += 1;
    const attempt = this.#attempt;
    this.#free();
    if (typeof choice === "string") this.#choice = choice;
    // Without the module nothing can be opened, and that is no fault of a backend.
    await wasmModule();
    const backends = typeof choice === "string" ? candidates(choice) : choice;
    // Some backends fail before they touch their canvas; the next one can have it.
    let canvas: Promise<Canvas> | null = null;
    const opened = await openFirst(
      backends,
      async (backend) => {
        canvas ??= this.#newCanvas();
        const painter = await openPainter(backend, () => canvas as Promise<Canvas>, backend === this.#choice);
        try {
          // Whoever loads the avatar tells why it fails: that is no fault of the backend.
          await avatar.catch(() => {});
          const viewer = this.#host.viewer();
          if (viewer) await this.#host.prepare(painter, viewer);
        } catch (thrown) {
          if (!isPanic(thrown)) painter.free();
          throw thrown;
        }
        return painter;
      },
      // Whoever leaves the choice to the element has nothing to be told of.
      choice === "auto" ? () => {} : tell,
    );
    const drawnOn = await (canvas as Promise<Canvas> | null);
    if (attempt !== this.#attempt || this.#closed || !this.#host.viewer()) {
      opened.value.free();
      return;
    }
    this.#resizePainter(opened.value);
    this.#opened = opened;
    this.#canvas = drawnOn;
    this.#host.opened(opened.backend);
  }

  /** The avatar has its detail now: the painter takes it, or a painter of the next backend that can. */
  async prepareDetail(): Promise<void> {
    const viewer = this.#host.viewer();
    const opened = this.#opened;
    if (!viewer || !opened) return;
    try {
      opened.value.prepareDetail(viewer);
    } catch (thrown) {
      const next = candidates(opened.backend).slice(1);
      if (!next[0] || isPanic(thrown)) throw thrown;
      tell(reasonForNext(opened.backend, thrown, next[0]));
      await this.open(next, Promise.resolve());
    }
  }

  /** After a fault of the device: another painter, of the same backend unless that keeps failing. */
  async recover(failure: Failure, now: number): Promise<void> {
    const backend = this.backend;
    if (!backend) return;
    console.warn(`crease-avatar: ${failure.message}. Starting again.`);
    this.#losses.push(now);
    while ((this.#losses[0] ?? now) < now - LOSS_WINDOW_MILLISECONDS) this.#losses.shift();
    let next = candidates(backend);
    if (this.#losses.length > MOST_LOSSES) {
      next = next.slice(1);
      this.#losses.length = 0;
      if (next.length === 0) throw new StageError(failure.code, failure.message, failure.url);
    }
    await this.#reopen(next);
  }

  /** A driver that restarts needs a moment: only then the next backends are tried, too. */
  async #reopen(backends: readonly Backend[]): Promise<void> {
    for (let patience = MOST_RETRIES; patience > 0 && !this.#closed; patience -= 1) {
      try {
        await this.open(backends.slice(0, 1), Promise.resolve());
        return;
      } catch {
        await new Promise((resolve) => setTimeout(resolve, RETRY_MILLISECONDS));
      }
    }
    if (!this.#closed) await this.open(backends, Promise.resolve());
  }

  /** Takes the canvas that was asked for. */
  takeCanvas(canvas: Canvas): void {
    this.#giveCanvas?.(canvas);
    this.#giveCanvas = null;
  }

  /** Size of the screen, pixels. */
  resize(width: number, height: number): void {
    this.#size = { width, height };
    this.#resizePainter(this.painter);
  }

  /** Pixels of the picture a side, as a share of the screen's; the browser scales it up. */
  share(share: number): void {
    if (share === this.#share) return;
    this.#share = share;
    this.#resizePainter(this.painter);
  }

  /** Lets `draw` draw with another size of the picture, unless that is null; the screen's own comes back with the next picture. */
  withSize<T>(size: { width: number; height: number } | null, draw: () => T): T {
    if (!size) {
      this.share(1);
      return draw();
    }
    this.painter?.resize(size.width, size.height);
    try {
      return draw();
    } finally {
      this.#resizePainter(this.painter);
    }
  }

  #resizePainter(painter: Painter | null): void {
    if (!this.#size) return;
    painter?.resize(Math.round(this.#share * this.#size.width), Math.round(this.#share * this.#size.height));
  }

  /** Whether there is something to draw on. */
  get ready(): boolean {
    return this.#opened !== null && this.#size !== null;
  }

  /** Frees the device. */
  close(): void {
    this.#closed = true;
    this.#free();
  }

  #free(): void {
    this.#opened?.value.free();
    this.#opened = null;
    this.#canvas = null;
  }

  #newCanvas(): Promise<Canvas> {
    return new Promise((resolve) => {
      this.#giveCanvas = resolve;
      this.#host.askForCanvas();
    });
  }
}
