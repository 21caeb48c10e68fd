/** What the page and the stage (usually in a worker) say to each other. */

import type { Shared } from "./threads.js";

/** What is shown: the figure at some stage of the pipeline, or something about its detailed surface. */
export type View = "detailed" | "base" | "body" | "wireframe" | "normals" | "laplacian";

/** Light on the figure. */
export type Environment = "studio" | "daylight" | "sunset" | "night";

/** What the camera does where the figure goes: it comes along softly, it keeps the root in the middle, or it stays. */
export type Follow = "soft" | "root" | "none";

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

/**
 * Why something does not work, for programs.
 *
 * - `unsupported`: nothing on this machine can draw the figure, or do what was asked for.
 * - `network`: no answer, an answer that the other site does not share (CORS), or a download that broke off.
 * - `http`: an answer with an error status, such as 404.
 * - `type`: a web page came in place of a file.
 * - `too-large`: more bytes than `max-bytes`.
 * - `avatar`, `motion`, `texture`, `pose`: the file or the numbers are no such thing, or one for another body.
 * - `canvas`, `device`, `device-lost`: the picture cannot be drawn any more.
 * - `version`: script, worker and wasm module are not of the same build, as a cache has kept some of them.
 * - `internal`: a fault of this element.
 */
export type ErrorCode =
  | "unsupported"
  | "network"
  | "http"
  | "type"
  | "too-large"
  | "avatar"
  | "motion"
  | "pose"
  | "texture"
  | "canvas"
  | "device"
  | "device-lost"
  | "version"
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

/** A camera's place about its target; null stands for the first view's. Radians and metres, or a share of the first view's distance. */
export interface OrbitWish {
  /** About the vertical: 0 looks at the figure's front, positive moves the eye to the figure's left. */
  readonly azimuth: number | null;
  /** Above the horizon. */
  readonly elevation: number | null;
  readonly distance: { readonly metres: number } | { readonly share: number } | null;
}

/** Red, green, blue and opacity of a colour in sRGB, 0 to 1. */
export type Colour = readonly [number, number, number, number];

/** Everything that lasts; sent whole when a stage opens and in parts afterwards. */
export interface Settings {
  readonly view: View;
  readonly detail: number;
  readonly liveliness: number;
  readonly theme: Theme;
  /** Behind the figure; null is the theme's own. */
  readonly background: Colour | null;
  readonly environment: Environment;
  /** Strength of the shadow on the floor, 0 to 1. */
  readonly shadow: number;
  readonly follow: Follow;
  readonly orbit: OrbitWish;
  /** What the camera looks at, metres; null is the first view's. */
  readonly target: readonly [number, number, number] | null;
  /** Vertical, radians; null is the first view's. */
  readonly fieldOfView: number | null;
  /** Radians a second by which the camera turns by itself, and seconds for which it rests after it was moved. */
  readonly turn: { readonly radiansPerSecond: number; readonly restSeconds: number };
  readonly loop: boolean;
  readonly playbackRate: number;
  readonly motions: readonly MotionSource[];
  /** Seconds over which a motion fades into the next one. */
  readonly crossfade: number;
  /** Address of a picture, or of an avatar whose texture is taken. */
  readonly texture: string | null;
  /** Address of an avatar whose wrinkles are worn. */
  readonly detailFrom: string | null;
  /** Seconds in which a live pose covers 63 % of its way. */
  readonly smoothing: number;
  readonly backend: BackendChoice;
  readonly quality: QualityChoice;
  /** Largest file that is accepted; null is any. */
  readonly maxBytes: number | null;
}

/** What time shall do. A higher `order` is a later wish; frames tell which one they obey. */
export interface ClockWish {
  readonly order: number;
  readonly playing: boolean;
  /** Where to go first; null stays. */
  readonly seconds: number | null;
}

/** A pose in place of the motions: axis-angle, three numbers a joint; null gives the motions back. */
export interface LivePose {
  readonly pose: Float32Array | null;
  readonly translation: Float32Array | null;
}

/** A picture as a file. */
export interface PictureWish {
  readonly type: string;
  readonly quality: number | null;
  /** Size in pixels; null is the element's. */
  readonly size: { readonly width: number; readonly height: number } | null;
}

/** Kinds of mesh files. */
export type MeshFormat = "glb" | "obj" | "ply";

/** Something that is asked for once and answered once. */
export type Request =
  | { readonly kind: "picture"; readonly wish: PictureWish }
  | { readonly kind: "mesh"; readonly format: MeshFormat }
  | { readonly kind: "render-frame"; readonly seconds: number; readonly order: number }
  | {
      readonly kind: "record";
      readonly seconds: number;
      readonly framesPerSecond: number;
      readonly bitsPerSecond: number | null;
      readonly size: { readonly width: number; readonly height: number } | null;
    };

/** A movement of the camera. Angles in radians, shares of the picture's height, factors. */
export type CameraMove =
  | { readonly kind: "orbit"; readonly azimuth: number; readonly elevation: number }
  | { readonly kind: "pan"; readonly right: number; readonly up: number }
  | { readonly kind: "zoom"; readonly factor: number }
  | { readonly kind: "reset" }
  | { readonly kind: "jump" };

/** Where the camera is: radians, metres. */
export interface CameraPlace {
  readonly azimuth: number;
  readonly elevation: number;
  readonly distance: number;
  readonly target: readonly [number, number, number];
  readonly fieldOfView: number;
}

/** A message to or from one of the stages that share a worker. */
export interface Addressed<T> {
  readonly stage: number;
  readonly message: T;
}

/** From the page to the stage. */
export type Command =
  | { readonly kind: "open"; readonly url: string; readonly settings: Settings; readonly clock: ClockWish }
  | { readonly kind: "canvas"; readonly canvas: Canvas }
  | { readonly kind: "settings"; readonly settings: Partial<Settings> }
  | { readonly kind: "resize"; readonly width: number; readonly height: number }
  | { readonly kind: "clock"; readonly wish: ClockWish }
  | { readonly kind: "pose"; readonly live: LivePose }
  | { readonly kind: "request"; readonly id: number; readonly request: Request }
  | { readonly kind: "camera"; readonly move: CameraMove }
  | { readonly kind: "visible"; readonly visible: boolean }
  | { readonly kind: "lose-device" }
  | { readonly kind: "close" };

/** What posing consists of, in its order. */
export const POSE_PARTS = ["deformation", "base", "laplacian", "residual", "solve", "surface"] as const;

/** What a drawn frame tells. */
export interface Frame {
  /** The wish for the clock that it obeys. */
  readonly order: number;
  readonly currentTime: number;
  readonly ended: boolean;
  /** Which motion of the playlist it shows. */
  readonly motionIndex: number;
  readonly camera: CameraPlace;
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
  /** What setting up the detail took; null where this picture is of the base, as the detail is not there yet. */
  readonly detailSetupMilliseconds: number | null;
  /** Bytes of the wasm module's memory. */
  readonly memoryBytes: number;
  /** Bytes of buffers and textures on the GPU, without the canvas; null where WebGL2 draws, which does not count them. */
  readonly gpuBytes: number | null;
}

/** To the worker, before everything else: how many threads may share a frame. */
export interface Begin {
  readonly threads: number;
}

/** To a worker that is to be a thread of a module. */
export interface ThreadStart extends Shared {
  readonly build: string;
}

/** From it, once: it takes part from now on. */
export type ThreadReport = "running";

/** From the stage to the page. */
export type Report =
  | { readonly kind: "capability"; readonly build: string; readonly webgpu: boolean; readonly animationFrames: boolean }
  | { readonly kind: "threads-wanted"; readonly shared: Shared }
  | { readonly kind: "canvas-wanted" }
  | { readonly kind: "progress"; readonly phase: Phase; readonly loaded: number; readonly total: number | null }
  | { readonly kind: "loaded"; readonly vertices: number }
  | { readonly kind: "backend"; readonly backend: Backend }
  | {
      readonly kind: "motion";
      readonly duration: number;
      readonly framesPerSecond: number;
      readonly notes: readonly string[];
    }
  /** A wish for the clock was obeyed while nothing is drawn. */
  | { readonly kind: "time"; readonly order: number; readonly currentTime: number }
  | { readonly kind: "answer"; readonly id: number; readonly value?: Blob; readonly failure?: Failure }
  | { readonly kind: "frame"; readonly frame: Frame }
  /** After a fatal failure nothing more is drawn. */
  | { readonly kind: "failed"; readonly failure: Failure; readonly fatal: boolean };
