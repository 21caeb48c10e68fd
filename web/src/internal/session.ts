import { type Connection, connect } from "./connection.js";
import { failureOf } from "./fetch.js";
import type { CameraMove, Command, Failure, Frame, Settings } from "./protocol.js";
import { FrameCounter } from "./statistics.js";

/** What a session tells its element. */
export interface SessionEvents {
  /** The canvas to draw on is needed now. */
  canvas(): HTMLCanvasElement;
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

  constructor(url: string, settings: () => Settings, events: SessionEvents) {
    this.#url = url;
    this.#events = events;
    this.#connection = this.#open(settings);
  }

  async #open(settings: () => Settings): Promise<Connection | null> {
    try {
      const connection = await connect((report) => {
        if (this.#closed) return;
        if (report.kind === "loaded") {
          this.counter.vertices = report.vertices;
          this.counter.backend = report.backend;
        } else if (report.kind === "motion") {
          this.#events.motion(report.duration, report.notes);
        } else if (report.kind === "frame") {
          this.counter.count(report.frame);
          this.#events.frame(report.frame, this.counter.statistics().frames === 1);
        } else if (report.kind === "failed") {
          this.#fail(report.failure);
        }
      });
      if (this.#closed) {
        connection.close();
        return null;
      }
      this.counter.thread = connection.thread;
      connection.open(this.#events.canvas(), { url: this.#url, settings: settings() });
      return connection;
    } catch (thrown) {
      if (!this.#closed) this.#fail(failureOf(thrown, this.#url));
      return null;
    }
  }

  #fail(failure: Failure): void {
    // A motion that fails leaves the avatar standing.
    const fatal = failure.code !== "motion" && !(failure.code === "network" && failure.url !== this.#url);
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
