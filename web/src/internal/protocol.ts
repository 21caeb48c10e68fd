/** What the page and the stage (usually in a worker) say to each other. */

/** How far down the pipeline a frame goes. */
export type View = "body" | "base" | "detailed";

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
}

/** A movement of the camera. Angles in radians, shares of the picture's height, factors. */
export type CameraMove =
  | { readonly kind: "orbit"; readonly azimuth: number; readonly elevation: number }
  | { readonly kind: "pan"; readonly right: number; readonly up: number }
  | { readonly kind: "zoom"; readonly factor: number }
  | { readonly kind: "reset" };

/** From the page to the stage. */
export type Command =
  | {
      readonly kind: "open";
      readonly canvas: OffscreenCanvas | HTMLCanvasElement;
      readonly url: string;
      readonly settings: Settings;
    }
  | { readonly kind: "settings"; readonly settings: Partial<Settings> }
  | { readonly kind: "resize"; readonly width: number; readonly height: number }
  | { readonly kind: "seek"; readonly seconds: number }
  | { readonly kind: "camera"; readonly move: CameraMove }
  | { readonly kind: "visible"; readonly visible: boolean }
  | { readonly kind: "close" };

/** What a drawn frame tells. */
export interface Frame {
  readonly currentTime: number;
  readonly playing: boolean;
  readonly ended: boolean;
  /** From the frame before, where that one was shown just before this one. */
  readonly intervalMilliseconds: number | null;
  /** Networks, solve, normals and upload; null where only the camera moved. */
  readonly poseMilliseconds: number | null;
}

/** From the stage to the page. */
export type Report =
  | { readonly kind: "capability"; readonly webgpu: boolean }
  | { readonly kind: "loaded"; readonly vertices: number; readonly backend: string }
  | {
      readonly kind: "motion";
      readonly url: string | null;
      readonly duration: number;
      readonly notes: readonly string[];
    }
  | { readonly kind: "frame"; readonly frame: Frame }
  | { readonly kind: "failed"; readonly failure: Failure };
