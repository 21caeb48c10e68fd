import { type Connection, connect } from "./connection.js";
import { CreaseError } from "./crease-error.js";
import { failureOf } from "./errors.js";
import type {
  Backend,
  CameraMove,
  ClockWish,
  Command,
  Failure,
  Frame,
  Phase,
  Report,
  Request,
  Settings,
} from "./protocol.js";
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
  /** A wish for the clock was obeyed without a picture. */
  time(order: number, currentTime: number): void;
  /** Motions were loaded, or taken away. */
  motion(duration: number, framesPerSecond: number, notes: readonly string[]): void;
  /** Something failed. After a fatal failure nothing more is drawn. */
  failed(failure: Failure, fatal: boolean): void;
}

/** Someone who waits for an answer. */
interface Asking {
  resolve(value: Blob | undefined): void;
  reject(error: CreaseError): void;
}

/** One avatar from being asked for to being let go. */
export class Session {
  readonly counter = new FrameCounter();
  readonly #url: string;
  readonly #events: SessionEvents;
  readonly #connection: Promise<Connection | null>;
  readonly #asking = new Map<number, Asking>();
  #nextRequest = 1;
  #closed = false;
  #fatal = false;
  #shown = false;

  constructor(url: string, opening: () => { settings: Settings; clock: ClockWish }, events: SessionEvents) {
    this.#url = url;
    this.#events = events;
    this.#connection = this.#open(opening);
  }

  async #open(opening: () => { settings: Settings; clock: ClockWish }): Promise<Connection | null> {
    try {
      const connection = await connect((report) => {
        if (!this.#closed) this.#hear(report);
      });
      if (this.#closed) {
        connection.close();
        return null;
      }
      this.counter.connection = connection;
      connection.send({ kind: "open", url: this.#url, ...opening() });
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
        this.#events.motion(report.duration, report.framesPerSecond, report.notes);
        break;
      case "time":
        this.#events.time(report.order, report.currentTime);
        break;
      case "frame":
        this.counter.count(report.frame);
        if (!this.#shown) this.#events.shown();
        this.#shown = true;
        this.#events.frame(report.frame, this.counter.statistics().frames === 1);
        break;
      case "answer": {
        const asking = this.#asking.get(report.id);
        this.#asking.delete(report.id);
        if (report.failure) asking?.reject(CreaseError.of(report.failure));
        else asking?.resolve(report.value);
        break;
      }
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

  /** Asks the stage for something. */
  request(request: Request): Promise<Blob | undefined> {
    const id = this.#nextRequest;
    this.#nextRequest += 1;
    return new Promise((resolve, reject) => {
      if (this.#closed) {
        reject(this.#goneError());
        return;
      }
      this.#asking.set(id, { resolve, reject });
      this.send({ kind: "request", id, request });
    });
  }

  /** Moves the camera. */
  moveCamera(move: CameraMove): void {
    this.send({ kind: "camera", move });
  }

  /** Frees what the stage holds. */
  close(): void {
    if (this.#closed) return;
    this.#closed = true;
    for (const asking of this.#asking.values()) asking.reject(this.#goneError());
    this.#asking.clear();
    void this.#connection.then((connection) => connection?.close());
  }

  #goneError(): CreaseError {
    return new CreaseError("canvas", "expected an avatar that is shown, found one that was taken away", this.#url);
  }
}
