/** What the page and the stage (usually in a worker) say to each other. */

/** How far down the pipeline a frame goes. */
export type View = "body" | "base" | "detailed";

/** What computes and what draws. */
export type Backend = "webgpu" | "webgpu+cpu" | "webgl2+cpu";

/** A backend, or the best one that works. */
export type BackendChoice = Backend | "auto";

/** A level of quality by name, best first, or `auto`: the one that the machine holds. */
export type QualityChoice = "auto" | "best" | "high" | "medium" | "low" | "lowest";

/** What is drawn on. */
export type Canvas = OffscreenCanvas | HTMLCanvasElement;

/** What a load is doing. */
export type Phase = "download" | "prepare";

/** Colours around the figure. */
export type Theme = "light" | "dark";

/** Why something does not work, for programs. */
export type ErrorCode =
  | "unsupported"
  | "network"
  | "avatar"
  | "motion"
  | "texture"
  | "canvas"
  | "device"
  | "device-lost"
  | "internal";

/** An error as it crosses the worker's border. */
export interface Failure {
  readonly code: ErrorCode;
  readonly message: string;
  readonly url: string | null;
}

/** Where a motion is, and its rate where the file has none. */
export interface MotionSource {
  readonly url: string;
  readonly framesPerSecond: number | null;
}

/** Everything that lasts; sent whole when a stage opens and in parts afterwards. */
export interface Settings {
  readonly view: View;
  readonly detail: number;
  readonly theme: Theme;
  readonly playing: boolean;
  readonly loop: boolean;
  readonly playbackRate: number;
  readonly motion: MotionSource | null;
  readonly backend: BackendChoice;
  readonly quality: QualityChoice;
}

/** A movement of the camera. Angles in radians, shares of the picture's height, factors. */
export type CameraMove =
  | { readonly kind: "orbit"; readonly azimuth: number; readonly elevation: number }
  | { readonly kind: "pan"; readonly right: number; readonly up: number }
  | { readonly kind: "zoom"; readonly factor: number }
  | { readonly kind: "reset" };

/** From the page to the stage. */
export type Command =
  | { readonly kind: "open"; readonly url: string; readonly settings: Settings }
  | { readonly kind: "canvas"; readonly canvas: Canvas }
  | { readonly kind: "settings"; readonly settings: Partial<Settings> }
  | { readonly kind: "resize"; readonly width: number; readonly height: number }
  | { readonly kind: "seek"; readonly seconds: number }
  | { readonly kind: "camera"; readonly move: CameraMove }
  | { readonly kind: "visible"; readonly visible: boolean }
  | { readonly kind: "lose-device" }
  | { readonly kind: "close" };

/** What posing consists of, in its order. */
export const POSE_PARTS = ["deformation", "base", "laplacian", "residual", "solve", "surface"] as const;

/** What a drawn frame tells. */
export interface Frame {
  readonly currentTime: number;
  readonly playing: boolean;
  readonly ended: boolean;
  /** From the frame before, where that one was shown just before this one. */
  readonly intervalMilliseconds: number | null;
  /** Networks, solve, normals and packing; null where only the camera moved. */
  readonly poseMilliseconds: number | null;
  /** The parts of that, in the order of {@link POSE_PARTS}; null where only the camera moved. */
  readonly partMilliseconds: readonly number[] | null;
  /** Upload and the commands of all passes, on the CPU. */
  readonly drawMilliseconds: number;
  /** Iterations of the solver. */
  readonly iterations: number;
  /** Vertices of the mesh that is drawn. */
  readonly vertices: number;
  /** Level of quality that is shown. */
  readonly quality: string;
  /** Bytes of the wasm module's memory. */
  readonly memoryBytes: number;
}

/** From the stage to the page. */
export type Report =
  | { readonly kind: "capability"; readonly webgpu: boolean; readonly animationFrames: boolean }
  | { readonly kind: "canvas-wanted" }
  | { readonly kind: "progress"; readonly phase: Phase; readonly loaded: number; readonly total: number | null }
  | { readonly kind: "loaded"; readonly vertices: number }
  | { readonly kind: "backend"; readonly backend: Backend }
  | {
      readonly kind: "motion";
      readonly url: string | null;
      readonly duration: number;
      readonly notes: readonly string[];
    }
  | { readonly kind: "frame"; readonly frame: Frame }
  /** After a fatal failure nothing more is drawn. */
  | { readonly kind: "failed"; readonly failure: Failure; readonly fatal: boolean };
