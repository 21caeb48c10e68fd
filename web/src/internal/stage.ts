import type { Viewer } from "../../pkg/crease.js";
import { answer, type Studio } from "./answers.js";
import { applySettings, cameraPlace, moveCamera } from "./apply-settings.js";
import { failureOf, StageError } from "./errors.js";
import { fetchBytes, fileName } from "./fetch.js";
import { LatestLoad } from "./latest-load.js";
import { wasmModule } from "./module.js";
import type { Painter } from "./painter.js";
import {
  type ClockWish,
  type Command,
  type Failure,
  type LivePose,
  POSE_PARTS,
  type Report,
  type Settings,
} from "./protocol.js";
import { Screen } from "./screen.js";
import { type EncodedImage, loadTexture, ownTexture, setTexture } from "./texture.js";

/** How often an idle stage asks the GPU whether it still works. */
const CHECK_INTERVAL = 500;

/** What the first picture waits for: nobody wants to see the rest pose, or other clothes, flash by. */
type Awaited = "motions" | "texture" | "detail";

/** Runs one avatar on one screen: obeys commands, sends reports. Works in a worker and on the main thread. */
export class Stage {
  readonly #report: (report: Report) => void;
  readonly #screen: Screen;
  readonly #awaited = new Set<Awaited>(["motions"]);
  readonly #loads = {
    avatar: new LatestLoad(),
    motions: new LatestLoad(),
    texture: new LatestLoad(),
    detail: new LatestLoad(),
  };
  #viewer: Viewer | null = null;
  #url: string | null = null;
  #settings: Partial<Settings> = {};
  #wish: ClockWish = { order: 0, playing: false, seconds: null };
  #live: LivePose | null = null;
  /** The texture that replaces the avatar's own. */
  #texture: EncodedImage | null = null;
  /** Requests are answered one after the other. */
  #answering: Promise<void> = Promise.resolve();
  readonly #waiting: (() => void)[] = [];
  #visible = true;
  #closed = false;
  #drawn = false;
  #recovering = false;
  /** Something draws frame by frame; the screen's own rhythm has to wait. */
  #busy = false;
  #request = 0;
  #checks: ReturnType<typeof setInterval> | undefined;
  #lastFrame: number | null = null;
  #resting = true;
  #motionLoaded = false;

  constructor(report: (report: Report) => void) {
    this.#report = report;
    this.#screen = new Screen({
      askForCanvas: () => report({ kind: "canvas-wanted" }),
      viewer: () => this.#viewer,
      prepare: (painter, viewer) => this.#prepare(painter, viewer),
      opened: (backend) => {
        this.#viewer?.poseAgain();
        report({ kind: "backend", backend });
        // It may have come while the painter was being made.
        if (this.#viewer?.detailMilliseconds !== undefined) {
          void this.#guard(this.#url, () => this.#screen.prepareDetail());
        }
        this.#schedule();
      },
    });
  }

  /** Does what `command` says. */
  handle(command: Command): void {
    switch (command.kind) {
      case "open":
        this.#settings = { ...command.settings, ...this.#settings };
        this.#wish = command.clock;
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
      case "clock":
        this.#setClock(command.wish);
        break;
      case "pose":
        this.#live = command.live;
        void this.#guard(null, () => this.#applyPose());
        break;
      case "camera":
        if (this.#viewer) moveCamera(this.#viewer, command.move);
        break;
      case "visible":
        this.#visible = command.visible;
        this.#stop();
        break;
      case "request":
        this.#answering = this.#answering.then(() => this.#answer(command));
        return;
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
    viewer.jumpCamera();
    this.#setClock(this.#wish);
    if (this.#live) void this.#guard(null, () => this.#applyPose());
    this.#schedule();
  }

  async #load(url: string): Promise<void> {
    const download = fetchBytes(url, {
      signal: this.#loads.avatar.begin(),
      maxBytes: this.#maxBytes,
      onBytes: (loaded, total) => this.#report({ kind: "progress", phase: "download", loaded, total }),
    });
    const [bytes, runtime] = await Promise.all([download, wasmModule()]);
    if (this.#closed) return;
    this.#report({ kind: "progress", phase: "prepare", loaded: bytes.length, total: bytes.length });
    const viewer = new runtime.Viewer(bytes, fileName(url));
    // A quality that is demanded holds from the first picture on.
    if (this.#settings.quality !== "auto") viewer.prepareDetail();
    this.#viewer = viewer;
  }

  get #maxBytes(): number | null {
    return this.#settings.maxBytes ?? null;
  }

  /** Settings that came before the avatar wait in `#settings` until it is there. */
  #apply(settings: Partial<Settings>): void {
    const viewer = this.#viewer;
    if (!viewer) return;
    void this.#guard(this.#url, () => applySettings(viewer, settings));
    const { motions, crossfade, texture, detailFrom, backend } = settings;
    if (crossfade !== undefined) {
      const { duration } = viewer;
      viewer.setCrossfade(crossfade);
      if (viewer.duration !== duration) this.#tellMotion(viewer, []);
    }
    if (motions !== undefined) {
      this.#start("motions", null, (signal) => this.#loadMotions(viewer, motions, signal));
    }
    if (texture !== undefined && (texture !== null || this.#texture !== null || this.#awaited.has("texture"))) {
      this.#start("texture", texture, (signal) => this.#loadTexture(viewer, texture, signal));
    }
    if (detailFrom !== undefined && (detailFrom !== null || viewer.wearsOtherDetail || this.#awaited.has("detail"))) {
      this.#start("detail", detailFrom, (signal) => this.#loadDetail(viewer, detailFrom, signal));
    }
    if (backend !== undefined) {
      void this.#guard(this.#url, () => this.#screen.open(backend, Promise.resolve()));
    }
    this.#schedule();
  }

  /** Starts a load in place of the one of that kind before it. */
  #start(kind: Awaited, url: string | null, load: (signal: AbortSignal) => Promise<void>): void {
    const signal = this.#loads[kind].begin();
    this.#awaited.add(kind);
    void this.#guard(url, () => load(signal), signal).then(() => {
      if (signal.aborted) return;
      this.#awaited.delete(kind);
      if (this.#awaited.size === 0) for (const tell of this.#waiting.splice(0)) tell();
      this.#schedule();
    });
  }

  /** All motions, or none of them: one that fails leaves those before at play. */
  async #loadMotions(viewer: Viewer, motions: Settings["motions"], signal: AbortSignal): Promise<void> {
    const options = { signal, maxBytes: this.#maxBytes };
    const files = await Promise.all(motions.map(({ url }) => fetchBytes(url, options)));
    if (signal.aborted) return;
    const notes: string[] = [];
    viewer.beginMotions();
    for (const [index, { url, framesPerSecond }] of motions.entries()) {
      try {
        notes.push(...viewer.readMotion(files[index] as Uint8Array, fileName(url), framesPerSecond ?? undefined));
      } catch (thrown) {
        const { code, message } = failureOf(thrown, url);
        throw new StageError(code, message, url);
      }
    }
    try {
      viewer.playMotions();
    } catch (thrown) {
      const { code, message } = failureOf(thrown, null);
      throw new StageError(code, message, motions[0]?.url ?? null);
    }
    this.#motionLoaded = motions.length > 0;
    if (this.#wish.seconds !== null) viewer.seek(this.#wish.seconds);
    this.#wish = { ...this.#wish, seconds: null };
    this.#tellMotion(viewer, notes);
  }

  #tellMotion({ duration, framesPerSecond }: Viewer, notes: readonly string[]): void {
    this.#report({ kind: "motion", duration, framesPerSecond, notes });
  }

  async #loadTexture(viewer: Viewer, url: string | null, signal: AbortSignal): Promise<void> {
    const texture = url === null ? null : await loadTexture(viewer, url, { signal, maxBytes: this.#maxBytes });
    if (signal.aborted) return;
    this.#texture = texture;
    const painter = this.#screen.painter;
    if (painter) await setTexture(painter, texture ?? ownTexture(viewer));
    viewer.redraw();
  }

  async #loadDetail(viewer: Viewer, url: string | null, signal: AbortSignal): Promise<void> {
    if (url === null) {
      viewer.wearOwnDetail();
    } else {
      const bytes = await fetchBytes(url, { signal, maxBytes: this.#maxBytes });
      if (signal.aborted) return;
      viewer.wearDetailOf(bytes, fileName(url));
    }
    const { painter, backend } = this.#screen;
    // A painter that poses has its own copy of the avatar.
    if (painter && backend === "webgpu") await this.#prepare(painter, viewer);
    viewer.poseAgain();
  }

  /** Gives `painter` the figure and its texture. */
  async #prepare(painter: Painter, viewer: Viewer): Promise<void> {
    painter.prepare(viewer);
    await setTexture(painter, this.#texture ?? ownTexture(viewer));
  }

  /** Before the motion is there, the wish for a time waits for it. */
  #setClock(wish: ClockWish): void {
    const viewer = this.#viewer;
    const seconds = wish.seconds ?? this.#wish.seconds;
    this.#wish = { ...wish, seconds };
    if (!viewer) return;
    if (wish.playing) viewer.play();
    else viewer.pause();
    if (!this.#motionLoaded || seconds === null) return;
    viewer.seek(seconds);
    this.#wish = { ...wish, seconds: null };
    if (!this.#visible) this.#report({ kind: "time", order: wish.order, currentTime: viewer.currentTime });
  }

  #applyPose(): void {
    this.#viewer?.setPose(this.#live?.pose ?? undefined, this.#live?.translation ?? undefined);
  }

  /** What was set before is in the answer: files that are on their way are waited for. */
  async #answer({ id, request }: Command & { kind: "request" }): Promise<void> {
    try {
      if (this.#awaited.size > 0) await new Promise<void>((resolve) => this.#waiting.push(resolve));
      // What leaves the page is never the base alone, unless that is wanted.
      await this.#prepareDetail();
      const value = await answer(request, () => this.#studio());
      this.#report(value ? { kind: "answer", id, value } : { kind: "answer", id });
    } catch (thrown) {
      this.#report({ kind: "answer", id, failure: failureOf(thrown, this.#url) });
    } finally {
      this.#busy = false;
      this.#schedule();
    }
  }

  /** What answers are made with. */
  #studio(): Studio {
    const viewer = this.#viewer;
    const { painter, canvas } = this.#screen;
    if (this.#closed || !viewer || !painter || !canvas) {
      throw new StageError("canvas", "expected an avatar that is shown, found none yet", this.#url);
    }
    return {
      viewer,
      canvas,
      texture: this.#texture ?? ownTexture(viewer),
      obey: (order) => {
        this.#wish = { order, playing: false, seconds: null };
      },
      wish: () => this.#wish,
      hold: () => {
        this.#busy = true;
        this.#stop();
      },
      draw: (now) => this.#drawNow(viewer, painter, now),
      withSize: (size, draw) => this.#screen.withSize(size, draw),
    };
  }

  #drawNow(viewer: Viewer, painter: Painter, now: number | null): void {
    if (now === null) viewer.skipTime();
    viewer.advance(now ?? performance.now(), painter.poses(viewer));
    const started = performance.now();
    if (!painter.draw(viewer)) throw new StageError("canvas", "expected a picture of some size, found none", this.#url);
    this.#rest();
    if (this.#busy) viewer.drawn(undefined, 0);
    else this.#onDrawn(viewer, started, performance.now() - started);
  }

  /** Asks for a frame only when it would differ from the last: an idle figure costs nothing. */
  #schedule(): void {
    if (this.#request || this.#busy || !this.#visible || !this.#screen.ready || !this.#viewer?.moving) return;
    if (!this.#drawn && this.#awaited.size > 0) return;
    this.#request = requestAnimationFrame((now) => {
      this.#request = 0;
      if (this.#check()) void this.#guard(this.#url, () => this.#frame(now));
    });
  }

  #frame(now: number): void {
    const viewer = this.#viewer;
    const painter = this.#screen.painter;
    if (!viewer || !painter) return;
    // Time begins with the first frame after a rest.
    if (this.#resting) viewer.skipTime();
    this.#resting = false;
    if (painter.keepsUp() && viewer.advance(now, painter.poses(viewer))) {
      this.#screen.share(viewer.pixelShare);
      const started = performance.now();
      if (painter.draw(viewer)) this.#onDrawn(viewer, now, performance.now() - started);
    }
    if (!viewer.moving) this.#rest();
    this.#schedule();
  }

  #onDrawn(viewer: Viewer, now: number, drawMilliseconds: number): void {
    const interval = this.#lastFrame === null ? null : now - this.#lastFrame;
    const pose = viewer.poseMilliseconds ?? null;
    viewer.drawn(interval ?? undefined, (pose ?? 0) + drawMilliseconds);
    if (!this.#drawn) setTimeout(() => void this.#guard(this.#url, () => this.#prepareDetail()));
    this.#drawn = true;
    this.#lastFrame = now;
    this.#report({
      kind: "frame",
      frame: {
        order: this.#wish.order,
        currentTime: viewer.currentTime,
        ended: viewer.ended,
        motionIndex: viewer.motionIndex,
        camera: cameraPlace(viewer),
        intervalMilliseconds: interval,
        poseMilliseconds: pose,
        partMilliseconds: pose === null ? null : POSE_PARTS.map((_, part) => viewer.partMilliseconds(part)),
        drawMilliseconds,
        iterations: viewer.iterations,
        // A painter that poses keeps the finest level to itself.
        vertices: viewer.vertexCount || viewer.vertices,
        quality: viewer.quality,
        detailSetupMilliseconds: viewer.detailMilliseconds ?? null,
        memoryBytes: viewer.memoryBytes,
        gpuBytes: this.#screen.painter?.gpuBytes ?? null,
      },
    });
  }

  /** The first picture, of the base, did not wait for the detail. */
  async #prepareDetail(): Promise<void> {
    const viewer = this.#viewer;
    if (!viewer || viewer.detailMilliseconds !== undefined) return;
    viewer.prepareDetail();
    await this.#screen.prepareDetail();
    this.#schedule();
  }

  #stop(): void {
    cancelAnimationFrame(this.#request);
    this.#request = 0;
    this.#rest();
  }

  #rest(): void {
    this.#resting = true;
    this.#lastFrame = null;
  }

  #close(): void {
    this.#closed = true;
    this.#stop();
    for (const load of Object.values(this.#loads)) load.cancel();
    clearInterval(this.#checks);
    try {
      this.#screen.close();
      this.#viewer?.free();
    } catch {
      // What a panic has borrowed goes with the worker.
    }
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

  /** Reports what `action` throws, unless it was cancelled. */
  async #guard(url: string | null, action: () => void | Promise<void>, signal?: AbortSignal): Promise<void> {
    try {
      await action();
    } catch (thrown) {
      if (this.#closed || signal?.aborted) return;
      const failure = failureOf(thrown, url);
      const fatal = this.#isFatal(failure);
      if (fatal) this.#close();
      this.#report({ kind: "failed", failure, fatal });
      this.#schedule();
    }
  }

  /**
   * Without its own file, or the wasm module, there is no avatar. A motion, a texture or other wrinkles that fail leave it as it was; a pose that fails leaves the
   * last good picture.
   */
  #isFatal({ code, url }: Failure): boolean {
    switch (code) {
      case "motion":
      case "pose":
        return false;
      case "network":
      case "http":
      case "type":
      case "too-large":
        return url === this.#url || !this.#viewer;
      case "avatar":
      case "texture":
        return url === this.#url && !this.#drawn;
      default:
        return true;
    }
  }
}
