import type { Frame } from "./protocol.js";

/** Frames that the medians look back on. */
const WINDOW = 120;

/** What `<crease-avatar>` tells about its work. */
export interface Statistics {
  /** Pictures drawn since the avatar was asked for. */
  readonly frames: number;
  /** From asking for the avatar to its first picture; null before. */
  readonly firstFrameMilliseconds: number | null;
  /** From one picture to the next while it moves: median of up to the last 120; null before the second. */
  readonly frameMilliseconds: number | null;
  /** Networks, solve and normals of one picture: median of up to the last 120. */
  readonly poseMilliseconds: number | null;
  /** What computes and what draws, such as `webgpu+cpu`; null before the avatar is loaded. */
  readonly backend: string | null;
  /** Thread that does it; null before the avatar is loaded. */
  readonly thread: "worker" | "main" | null;
  /** Vertices of the mesh that is drawn. */
  readonly vertices: number;
}

/** The middle of `numbers`, or null of none. */
export function median(numbers: readonly number[]): number | null {
  const sorted = [...numbers].sort((a, b) => a - b);
  const upper = sorted[sorted.length >> 1];
  const lower = sorted[(sorted.length - 1) >> 1];
  return upper === undefined || lower === undefined ? null : (lower + upper) / 2;
}

/** Counts frames. */
export class FrameCounter {
  readonly #started = performance.now();
  readonly #intervals: number[] = [];
  readonly #poses: number[] = [];
  #frames = 0;
  #firstFrame: number | null = null;
  backend: string | null = null;
  thread: "worker" | "main" | null = null;
  vertices = 0;

  /** Takes one drawn frame into account. */
  count(frame: Frame): void {
    this.#frames += 1;
    this.#firstFrame ??= performance.now() - this.#started;
    if (frame.intervalMilliseconds !== null) push(this.#intervals, frame.intervalMilliseconds);
    if (frame.poseMilliseconds !== null) push(this.#poses, frame.poseMilliseconds);
  }

  /** The figures now. */
  statistics(): Statistics {
    return {
      frames: this.#frames,
      firstFrameMilliseconds: this.#firstFrame,
      frameMilliseconds: median(this.#intervals),
      poseMilliseconds: median(this.#poses),
      backend: this.backend,
      thread: this.thread,
      vertices: this.vertices,
    };
  }
}

function push(window: number[], number: number): void {
  window.push(number);
  if (window.length > WINDOW) window.shift();
}
