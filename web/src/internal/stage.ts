import { Viewer } from "../../pkg/crease.js";
import { failureOf, StageError } from "./errors.js";
import { fetchBytes, fileName } from "./fetch.js";
import { wasmModule } from "./module.js";
import type { Painter } from "./painter.js";
import { type Command, type Failure, type MotionSource, POSE_PARTS, type Report, type Settings } from "./protocol.js";
import { Screen } from "./screen.js";

/** How often an idle stage asks the GPU whether it still works. */
const CHECK_INTERVAL = 500;

/** Runs one avatar on one screen: obeys commands, sends reports. Works in a worker and on the main thread. */
export class Stage {
  readonly #report: (report: Report) => void;
  readonly #screen: Screen;
  #viewer: Viewer | null = null;
  #url: string | null = null;
  #settings: Partial<Settings> = {};
  #seek: number | null = null;
  #visible = true;
  #closed = false;
  #drawn = false;
  #recovering = false;
  #request = 0;
  #checks: ReturnType<typeof setInterval> | undefined;
  #lastFrame: number | null = null;
  #motionLoads = 0;
  #motionLoaded = false;
  /** The first picture waits for the first motion: nobody wants to see the rest pose flash by. */
  #waiting = true;

  constructor(report: (report: Report) => void) {
    this.#report = report;
    this.#screen = new Screen({
      askForCanvas: () => report({ kind: "canvas-wanted" }),
      viewer: () => this.#viewer,
      prepare,
      opened: (backend) => {
        this.#viewer?.poseAgain();
        report({ kind: "backend", backend });
        this.#schedule();
      },
    });
  }

  /** Does what `command` says. */
  handle(command: Command): void {
    switch (command.kind) {
      case "open":
        this.#settings = { ...command.settings, ...this.#settings };
        void this.#guard(command.url, () => this.#open(command.url));
        return;
      case "canvas":
        this.#screen.takeCanvas(command.canvas);
        return;
      case "settings":
        this.#settings = { ...this.#settings, ...command.settings };
        this.#apply(command.settings);
        return;
      case "resize":
        this.#screen.resize(command.width, command.height);
        this.#viewer?.redraw();
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
      case "lose-device":
        this.#screen.painter?.lose();
        return;
      case "close":
        this.#close();
        return;
    }
    this.#schedule();
  }

  /** Module, avatar and device come side by side. */
  async #open(url: string): Promise<void> {
    this.#url = url;
    const avatar = this.#load(url);
    await Promise.all([avatar, this.#screen.open(this.#settings.backend ?? "auto", avatar)]);
    const viewer = this.#viewer;
    if (this.#closed || !viewer) return;
    this.#checks = setInterval(() => this.#check(), CHECK_INTERVAL);
    this.#report({ kind: "loaded", vertices: viewer.vertices });
    const { backend: _, ...settings } = this.#settings;
    this.#apply(settings);
  }

  async #load(url: string): Promise<void> {
    const download = fetchBytes(url, (loaded, total) => {
      this.#report({ kind: "progress", phase: "download", loaded, total });
    });
    const [bytes] = await Promise.all([download, wasmModule()]);
    if (this.#closed) return;
    this.#report({ kind: "progress", phase: "prepare", loaded: bytes.length, total: bytes.length });
    this.#viewer = new Viewer(bytes, fileName(url));
  }

  /** Settings that came before the avatar wait in `#settings` until it is there. */
  #apply(settings: Partial<Settings>): void {
    const viewer = this.#viewer;
    if (!viewer) return;
    void this.#guard(this.#url, () => {
      if (settings.view !== undefined) viewer.setView(settings.view);
      if (settings.detail !== undefined) viewer.setDetail(settings.detail);
      if (settings.theme !== undefined) viewer.setTheme(settings.theme);
      if (settings.quality !== undefined) viewer.setQuality(settings.quality);
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
    if (settings.backend !== undefined) {
      const { backend } = settings;
      void this.#guard(this.#url, () => this.#screen.open(backend, Promise.resolve()));
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
    if (this.#request || this.#waiting || !this.#visible || !this.#screen.ready || !this.#viewer?.moving) return;
    this.#request = requestAnimationFrame((now) => {
      this.#request = 0;
      if (this.#check()) void this.#guard(this.#url, () => this.#frame(now));
    });
  }

  #frame(now: number): void {
    const viewer = this.#viewer;
    const painter = this.#screen.painter;
    if (!viewer || !painter) return;
    if (this.#lastFrame === null) viewer.skipTime();
    if (painter.keepsUp() && viewer.advance(now, painter.poses())) {
      this.#screen.share(viewer.pixelShare);
      const started = performance.now();
      if (painter.draw(viewer)) this.#onDrawn(viewer, now, performance.now() - started);
    }
    if (!viewer.moving) this.#lastFrame = null;
    this.#schedule();
  }

  #onDrawn(viewer: Viewer, now: number, drawMilliseconds: number): void {
    const interval = this.#lastFrame === null ? null : now - this.#lastFrame;
    const pose = viewer.poseMilliseconds ?? null;
    viewer.drawn(interval ?? undefined, (pose ?? 0) + drawMilliseconds);
    this.#drawn = true;
    this.#lastFrame = now;
    this.#report({
      kind: "frame",
      frame: {
        currentTime: viewer.currentTime,
        playing: viewer.playing,
        ended: viewer.ended,
        intervalMilliseconds: interval,
        poseMilliseconds: pose,
        partMilliseconds: pose === null ? null : POSE_PARTS.map((_, part) => viewer.partMilliseconds(part)),
        drawMilliseconds,
        iterations: viewer.iterations,
        // A painter that poses keeps the finest level to itself.
        vertices: viewer.vertexCount || viewer.vertices,
        quality: viewer.quality,
        memoryBytes: viewer.memoryBytes,
      },
    });
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
    this.#screen.close();
    this.#viewer?.free();
    this.#viewer = null;
  }

  /** Whether the device works. Where it does not, it is built again, and the motion goes on from where it was. */
  #check(): boolean {
    try {
      this.#screen.painter?.check();
      return true;
    } catch (thrown) {
      const failure = failureOf(thrown, this.#url);
      if (!this.#recovering) {
        this.#recovering = true;
        this.#stop();
        void this.#guard(this.#url, () => this.#screen.recover(failure, performance.now())).then(() => {
          this.#recovering = false;
        });
      }
      return false;
    }
  }

  /** Reports what `action` throws. */
  async #guard(url: string | null, action: () => void | Promise<void>): Promise<void> {
    try {
      await action();
    } catch (thrown) {
      if (this.#closed) return;
      const failure = failureOf(thrown, url);
      const fatal = this.#isFatal(failure);
      if (fatal) this.#close();
      this.#report({ kind: "failed", failure, fatal });
      this.#schedule();
    }
  }

  /** A motion that fails leaves the avatar standing; a pose that fails leaves the last good picture. */
  #isFatal(failure: Failure): boolean {
    if (failure.code === "motion") return false;
    if (failure.code === "network") return failure.url === this.#url;
    return !(failure.code === "avatar" && this.#drawn);
  }
}

/** Gives `painter` the figure and its texture. */
async function prepare(painter: Painter, viewer: Viewer): Promise<void> {
  painter.prepare(viewer);
  const image = viewer.textureImage;
  if (!image) return;
  const blob = new Blob([image.bytes as Uint8Array<ArrayBuffer>], { type: image.mime });
  image.free();
  let bitmap: ImageBitmap;
  try {
    bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  } catch (thrown) {
    throw new StageError("texture", `texture: expected a picture of type ${blob.type}, found ${String(thrown)}`);
  }
  painter.setTexture(bitmap);
  bitmap.close();
}
