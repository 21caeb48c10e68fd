import type { Viewer, WebGpuPainter } from "../../pkg/crease.js";
import { type Runtime, wasmModule } from "./module.js";
import type { Backend, Canvas } from "./protocol.js";

/** Whatever draws a viewer's scene on a canvas. */
export interface Painter {
  /** Takes what never changes about the viewer's figure, its detail where that is there. */
  prepare(viewer: Viewer): void;
  /** The viewer has its detail now: takes what never changes about that. Throws where it cannot. */
  prepareDetail(viewer: Viewer): void;
  /** Takes the decoded texture of the figure. */
  setTexture(bitmap: ImageBitmap): void;
  /** Bytes of buffers and textures on the GPU, without the canvas; undefined where that is not counted. */
  readonly gpuBytes?: number;
  /** Size of the picture in pixels of the device. */
  resize(width: number, height: number): void;
  /** Whether it poses the viewer's avatar by itself. */
  poses(viewer: Viewer): boolean;
  /** Whether another picture may be drawn now. */
  keepsUp(): boolean;
  /** Draws the viewer's scene. Returns whether there was something to draw on. */
  draw(viewer: Viewer): boolean;
  /** Throws if the device has reported an error or was lost. */
  check(): void;
  /** Loses the device as a driver's restart does, for tests. */
  lose(): void;
  /** Gives everything back. */
  free(): void;
}

/** Painters of WebGPU are made one after the other, so that the second finds the device of the first. */
let making: Promise<unknown> = Promise.resolve();

function makeWebGpuPainter(
  { WebGpuPainter }: Runtime,
  canvas: Canvas,
  computes: boolean,
  forced: boolean,
): Promise<WebGpuPainter> {
  const made = making.then(() => WebGpuPainter.create(canvas, computes, forced));
  making = made.catch(() => {});
  return made;
}

/** A painter on `canvas`; throws with the reason where this machine has none of that kind. `forced`: also where it is no gain. */
export async function openPainter(backend: Backend, canvas: () => Promise<Canvas>, forced: boolean): Promise<Painter> {
  switch (backend) {
    case "webgpu":
    case "webgpu+cpu":
      return await makeWebGpuPainter(await wasmModule(), await canvas(), backend === "webgpu", forced);
    case "webgl2+cpu": {
      const [{ WebGl2Painter }, runtime] = await Promise.all([import("./webgl2/painter.js"), wasmModule()]);
      return new WebGl2Painter(await canvas(), runtime);
    }
  }
}
