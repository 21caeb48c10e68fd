import type { Connection } from "./connection.js";
import { type Backend, type Frame, POSE_PARTS } from "./protocol.js";

/** Frames that the medians look back on. */
const WINDOW = 120;

/** What `<crease-avatar>` tells about its work. */
export interface Statistics {
  /** Pictures drawn since the avatar was asked for. */
  readonly frames: number;
  /** From asking for the avatar to its first picture; null before. */
  readonly firstFrameMilliseconds: number | null;
  /** From asking for the avatar to the first picture with its detail; null before. The pictures before show the base. */
  readonly firstDetailMilliseconds: number | null;
  /** Setting up the solver and what else the detail needs; null before. */
  readonly detailSetupMilliseconds: number | null;
  /** From one picture to the next while it moves: median of up to the last 120; null before the second. */
  readonly frameMilliseconds: number | null;
  /** Networks, solve and normals of one picture: median of up to the last 120. */
  readonly poseMilliseconds: number | null;
  /** The parts of posing: medians of the same frames. */
  readonly partMilliseconds: Readonly<Record<(typeof POSE_PARTS)[number], number | null>>;
  /** Upload and the commands of all passes: median of up to the last 120. */
  readonly drawMilliseconds: number | null;
  /** Iterations of the solver in the last picture. */
  readonly iterations: number;
  /** Level of quality of the last picture; null before there is one. */
  readonly quality: string | null;
  /** Bytes of the wasm module's memory. */
  readonly memoryBytes: number;
  /** Bytes of its buffers and textures on the GPU, without the canvas; null where WebGL2 draws, which does not count them. */
  readonly gpuBytes: number | null;
  /** What computes and what draws, such as `webgpu+cpu`; null before the avatar is loaded. */
  readonly backend: Backend | null;
  /** Thread that does it; null before the avatar is loaded. */
  readonly thread: "worker" | "main" | null;
  /** How many threads share a frame: more than one only in a page that is cross-origin isolated; null before the avatar is loaded. */
  readonly threads: number | null;
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
  readonly #draws: number[] = [];
  readonly #parts: readonly number[][] = POSE_PARTS.map(() => []);
  #last: Frame | null = null;
  #frames = 0;
  #firstFrame: number | null = null;
  #firstDetail: number | null = null;
  backend: Backend | null = null;
  connection: Connection | null = null;
  vertices = 0;

  /** Takes one drawn frame into account. */
  count(frame: Frame): void {
    this.#frames += 1;
    const sinceStart = performance.now() - this.#started;
    this.#firstFrame ??= sinceStart;
    if (frame.detailSetupMilliseconds !== null) this.#firstDetail ??= sinceStart;
    if (frame.intervalMilliseconds !== null) push(this.#intervals, frame.intervalMilliseconds);
    if (frame.poseMilliseconds !== null) push(this.#poses, frame.poseMilliseconds);
    for (const [index, part] of this.#parts.entries()) {
      const milliseconds = frame.partMilliseconds?.[index];
      if (milliseconds !== undefined) push(part, milliseconds);
    }
    push(this.#draws, frame.drawMilliseconds);
    this.vertices = frame.vertices;
    this.#last = frame;
  }

  /** The figures now. */
  statistics(): Statistics {
    return {
      frames: this.#frames,
      firstFrameMilliseconds: this.#firstFrame,
      firstDetailMilliseconds: this.#firstDetail,
      detailSetupMilliseconds: this.#last?.detailSetupMilliseconds ?? null,
      frameMilliseconds: median(this.#intervals),
      poseMilliseconds: median(this.#poses),
      partMilliseconds: Object.fromEntries(
        POSE_PARTS.map((name, index) => [name, median(this.#parts[index] ?? [])]),
      ) as Statistics["partMilliseconds"],
      drawMilliseconds: median(this.#draws),
      iterations: this.#last?.iterations ?? 0,
      quality: this.#last?.quality ?? null,
      memoryBytes: this.#last?.memoryBytes ?? 0,
      gpuBytes: this.#last?.gpuBytes ?? null,
      backend: this.backend,
      thread: this.connection?.thread ?? null,
      threads: this.connection?.threads ?? null,
      vertices: this.vertices,
    };
  }
}

function push(window: number[], number: number): void {
  window.push(number);
  if (window.length > WINDOW) window.shift();
}
