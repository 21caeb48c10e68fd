import { type Connection, connect } from "./connection.js";
import { failureOf } from "./errors.js";
import type { Backend, CameraMove, Command, Failure, Frame, Phase, Report, Settings } from "./protocol.js";
import { FrameCounter } from "./statistics.js";

/** How far a load is. */
export interface Progress {
  readonly phase: Phase;
  /** Bytes that have come. */
  readonly loaded: number;
  /** Bytes in all; null where the server does not say. */
  readonly total: number | null;
}

/** What a session tells its element. */
export interface SessionEvents {
  /** A new canvas to draw on is needed now. */
  canvas(): HTMLCanvasElement;
  /** The first picture is on the latest canvas. */
  shown(): void;
  /** How the load goes on. */
  progress(progress: Progress): void;
  /** This backend is at work now. */
  backend(backend: Backend): void;
  /** A picture was drawn. */
  frame(frame: Frame, first: boolean): void;
  /** A motion was loaded, or taken away. */
  motion(duration: number, notes: readonly string[]): void;
  /** Something failed. After a fatal failure nothing more is drawn. */
  failed(failure: Failure, fatal: boolean): void;
}

/** One avatar from being asked for to being let go. */
export class Session {
  readonly counter = new FrameCounter();
  readonly #url: string;
  readonly #events: SessionEvents;
  readonly #connection: Promise<Connection | null>;
  #closed = false;
  #fatal = false;
  #shown = false;

  constructor(url: string, settings: () => Settings, events: SessionEvents) {
    this.#url = url;
    this.#events = events;
    this.#connection = this.#open(settings);
  }

  async #open(settings: () => Settings): Promise<Connection | null> {
    try {
      const connection = await connect((report) => {
        if (!this.#closed) this.#hear(report);
      });
      if (this.#closed) {
        connection.close();
        return null;
      }
      this.counter.thread = connection.thread;
      connection.send({ kind: "open", url: this.#url, settings: settings() });
      return connection;
    } catch (thrown) {
      if (!this.#closed) this.#fail(failureOf(thrown, this.#url), true);
      return null;
    }
  }

  #hear(report: Report): void {
    switch (report.kind) {
      case "canvas-wanted":
        this.#shown = false;
        void this.#connection.then((connection) => {
          if (!this.#closed) connection?.giveCanvas(this.#events.canvas());
        });
        break;
      case "progress":
        this.#events.progress(report);
        break;
      case "loaded":
        this.counter.vertices = report.vertices;
        break;
      case "backend":
        this.counter.backend = report.backend;
        this.#events.backend(report.backend);
        break;
      case "motion":
        this.#events.motion(report.duration, report.notes);
        break;
      case "frame":
        this.counter.count(report.frame);
        if (!this.#shown) this.#events.shown();
        this.#shown = true;
        this.#events.frame(report.frame, this.counter.statistics().frames === 1);
        break;
      case "failed":
        this.#fail(report.failure, report.fatal);
        break;
    }
  }

  #fail(failure: Failure, fatal: boolean): void {
    if (fatal && this.#fatal) return;
    this.#fatal ||= fatal;
    this.#events.failed(failure, fatal);
  }

  /** Sends `command` once the stage is open; commands keep their order. */
  send(command: Command): void {
    void this.#connection.then((connection) => {
      if (!this.#closed) connection?.send(command);
    });
  }

  /** Moves the camera. */
  moveCamera(move: CameraMove): void {
    this.send({ kind: "camera", move });
  }

  /** Frees worker and GPU. */
  close(): void {
    if (this.#closed) return;
    this.#closed = true;
    void this.#connection.then((connection) => connection?.close());
  }
}
