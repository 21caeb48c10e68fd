import initialise, { Viewer } from "../../pkg/crease.js";
import { failureOf, fetchBytes, fileName, StageError } from "./fetch.js";
import type { Command, MotionSource, Report, Settings } from "./protocol.js";

/** How often an idle stage asks the GPU whether it still works. */
const CHECK_INTERVAL = 1000;

let wasm: Promise<unknown> | undefined;

/** Whether this thread can use WebGPU. */
export async function hasWebGpu(): Promise<boolean> {
  const { gpu } = navigator as Navigator & { gpu?: { requestAdapter(): Promise<unknown> } };
  return (await gpu?.requestAdapter().catch(() => null)) != null;
}

/** Runs one avatar on one canvas: obeys commands, sends reports. Works in a worker and on the main thread. */
export class Stage {
  readonly #report: (report: Report) => void;
  #viewer: Viewer | null = null;
  #url: string | null = null;
  #settings: Partial<Settings> = {};
  #size: { width: number; height: number } | null = null;
  #seek: number | null = null;
  #visible = true;
  #closed = false;
  #request = 0;
  #checks: ReturnType<typeof setInterval> | undefined;
  #lastFrame: number | null = null;
  #motionLoads = 0;
  #motionLoaded = false;
  /** The first picture waits for the first motion: nobody wants to see the rest pose flash by. */
  #waiting = true;

  constructor(report: (report: Report) => void) {
    this.#report = report;
  }

  /** Does what `command` says. */
  handle(command: Command): void {
    switch (command.kind) {
      case "open":
        this.#settings = { ...command.settings, ...this.#settings };
        void this.#guard(command.url, () => this.#open(command.canvas, command.url));
        return;
      case "settings":
        this.#settings = { ...this.#settings, ...command.settings };
        this.#apply(command.settings);
        return;
      case "resize":
        this.#size = { width: command.width, height: command.height };
        this.#viewer?.resize(command.width, command.height);
        break;
      case "seek":
        // Before the motion is there, the wish waits for it.
        if (this.#motionLoaded) this.#viewer?.seek(command.seconds);
        else this.#seek = command.seconds;
        break;
      case "camera":
        this.#move(command);
        break;
      case "visible":
        this.#visible = command.visible;
        this.#stop();
        break;
      case "close":
        this.#close();
        return;
    }
    this.#schedule();
  }

  async #open(canvas: OffscreenCanvas | HTMLCanvasElement, url: string): Promise<void> {
    this.#url = url;
    wasm ??= initialise();
    const [bytes] = await Promise.all([fetchBytes(url), wasm]);
    if (this.#closed) return;
    const viewer = await Viewer.create(canvas, bytes, fileName(url));
    if (this.#closed) {
      viewer.free();
      return;
    }
    await decodeTexture(viewer, url);
    if (this.#closed) {
      viewer.free();
      return;
    }
    this.#viewer = viewer;
    if (this.#size) viewer.resize(this.#size.width, this.#size.height);
    this.#checks = setInterval(() => void this.#guard(url, () => viewer.check()), CHECK_INTERVAL);
    this.#report({ kind: "loaded", vertices: viewer.vertices, backend: viewer.backend });
    this.#apply(this.#settings);
  }

  /** Settings that came before the avatar wait in `#settings` until it is there. */
  #apply(settings: Partial<Settings>): void {
    const viewer = this.#viewer;
    if (!viewer) return;
    void this.#guard(this.#url, () => {
      if (settings.view !== undefined) viewer.setView(settings.view);
      if (settings.detail !== undefined) viewer.setDetail(settings.detail);
      if (settings.theme !== undefined) viewer.setTheme(settings.theme);
      if (settings.loop !== undefined) viewer.setLoop(settings.loop);
      if (settings.playbackRate !== undefined) viewer.setPlaybackRate(settings.playbackRate);
      if (settings.playing !== undefined) settings.playing ? viewer.play() : viewer.pause();
    });
    if (settings.motion !== undefined) {
      const { motion } = settings;
      void this.#guard(motion?.url ?? null, () => this.#loadMotion(viewer, motion)).then(() => {
        this.#waiting = false;
        this.#schedule();
      });
    }
    this.#schedule();
  }

  /** The latest wish wins, whatever arrives first. */
  async #loadMotion(viewer: Viewer, motion: MotionSource | null): Promise<void> {
    this.#motionLoads += 1;
    const load = this.#motionLoads;
    let notes: readonly string[] = [];
    if (motion) {
      const bytes = await fetchBytes(motion.url);
      if (load !== this.#motionLoads || this.#closed) return;
      notes = viewer.loadMotion(bytes, fileName(motion.url), motion.framesPerSecond ?? undefined);
    } else {
      viewer.clearMotion();
    }
    if (this.#seek !== null) viewer.seek(this.#seek);
    this.#seek = null;
    this.#motionLoaded = motion !== null;
    this.#report({ kind: "motion", url: motion?.url ?? null, duration: viewer.duration, notes });
  }

  #move(command: Command & { kind: "camera" }): void {
    const { move } = command;
    switch (move.kind) {
      case "orbit":
        this.#viewer?.orbit(move.azimuth, move.elevation);
        break;
      case "pan":
        this.#viewer?.pan(move.right, move.up);
        break;
      case "zoom":
        this.#viewer?.zoom(move.factor);
        break;
      case "reset":
        this.#viewer?.resetCamera();
        break;
    }
  }

  /** Asks for a frame only when it would differ from the last: an idle figure costs nothing. */
  #schedule(): void {
    if (this.#request || this.#waiting || !this.#visible || !this.#size || !this.#viewer?.moving) return;
    this.#request = requestAnimationFrame((now) => {
      this.#request = 0;
      void this.#guard(this.#url, () => this.#frame(now));
    });
  }

  #frame(now: number): void {
    const viewer = this.#viewer;
    if (!viewer) return;
    if (this.#lastFrame === null) viewer.skipTime();
    if (viewer.frame(now)) {
      const interval = this.#lastFrame === null ? null : now - this.#lastFrame;
      this.#report({
        kind: "frame",
        frame: {
          currentTime: viewer.currentTime,
          playing: viewer.playing,
          ended: viewer.ended,
          intervalMilliseconds: interval,
          poseMilliseconds: viewer.poseMilliseconds ?? null,
        },
      });
      this.#lastFrame = now;
    }
    if (!viewer.moving) this.#lastFrame = null;
    this.#schedule();
  }

  #stop(): void {
    cancelAnimationFrame(this.#request);
    this.#request = 0;
    this.#lastFrame = null;
  }

  #close(): void {
    this.#closed = true;
    this.#stop();
    clearInterval(this.#checks);
    this.#viewer?.free();
    this.#viewer = null;
  }

  /** Reports what `action` throws. After a fault of the GPU nothing more can be drawn. */
  async #guard(url: string | null, action: () => void | Promise<void>): Promise<void> {
    try {
      await action();
    } catch (thrown) {
      if (this.#closed) return;
      const failure = failureOf(thrown, url);
      if (failure.code !== "motion" && failure.code !== "network") this.#close();
      this.#report({ kind: "failed", failure });
    }
  }
}

async function decodeTexture(viewer: Viewer, url: string): Promise<void> {
  const image = viewer.textureImage;
  if (!image) return;
  const blob = new Blob([image.bytes as Uint8Array<ArrayBuffer>], { type: image.mime });
  image.free();
  let bitmap: ImageBitmap;
  try {
    bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  } catch (thrown) {
    throw new StageError("texture", `texture: expected a picture of type ${blob.type}, found ${String(thrown)}`, url);
  }
  viewer.setTexture(bitmap);
  bitmap.close();
}
