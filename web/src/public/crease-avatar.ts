import { AttributedElement } from "../internal/attributes.js";
import { controlCamera } from "../internal/camera-controls.js";
import { CreaseError } from "../internal/crease-error.js";
import type {
  Backend,
  BackendChoice,
  ErrorCode,
  Failure,
  Frame,
  MotionSource,
  QualityChoice,
  Settings,
  Theme,
  View,
} from "../internal/protocol.js";
import { type Progress, Session } from "../internal/session.js";
import { ShadowTree } from "../internal/shadow.js";
import { FrameCounter, type Statistics } from "../internal/statistics.js";
import { watchSize, watchVisibility } from "../internal/visibility.js";

export type { Backend, BackendChoice, ErrorCode, Progress, QualityChoice, Statistics, Theme, View };
export { CreaseError };

/** Longest side of the picture, pixels. */
const LONGEST_SIDE = 3840;
/** Milliseconds between two `timeupdate` events. */
const TIME_UPDATE_INTERVAL = 250;

/**
 * `<crease-avatar src motion fps autoplay loop view detail theme alt camera-controls backend quality>`: an avatar that moves.
 *
 * Events: `progress` (bytes and phase of the load, a {@link Progress} in `detail`), `load` (first picture), `backendchange` (the
 * {@link Backend} now at work in `detail`), `error`, `play`, `pause`, `timeupdate`, `ended`, `durationchange`.
 */
export class CreaseAvatarElement extends AttributedElement {
  static readonly observedAttributes = [
    "src",
    "motion",
    "fps",
    "loop",
    "view",
    "detail",
    "theme",
    "alt",
    "camera-controls",
    "backend",
    "quality",
  ];

  readonly #tree: ShadowTree;
  #session: Session | null = null;
  #letGo: (() => void)[] = [];
  #letCameraGo: (() => void) | null = null;
  #opening = false;
  #error: CreaseError | null = null;
  #ready!: Promise<void>;
  #settleReady!: { resolve(): void; reject(error: CreaseError): void };
  #playing = false;
  #currentTime = 0;
  #duration = 0;
  #playbackRate = 1;
  #statistics: Statistics | null = null;
  #lastTimeUpdate = 0;
  #size: { width: number; height: number } | null = null;
  #visible = false;

  constructor() {
    super();
    this.#tree = new ShadowTree(this);
    this.#renewReady();
  }

  connectedCallback(): void {
    if (!this.hasAttribute("role")) this.setAttribute("role", "img");
    this.#describe();
    if (this.hasAttribute("autoplay")) this.#playing = true;
    const colours = matchMedia("(prefers-color-scheme: dark)");
    const onColours = (): void => this.#change({ theme: this.#themeNow() });
    colours.addEventListener("change", onColours);
    this.#letGo = [
      () => colours.removeEventListener("change", onColours),
      watchVisibility(this, (visible) => {
        this.#visible = visible;
        this.#session?.send({ kind: "visible", visible });
      }),
      watchSize(this, LONGEST_SIDE, (width, height) => {
        this.#size = { width, height };
        this.#session?.send({ kind: "resize", width, height });
      }),
    ];
    // For tests: the device goes away as it does when a driver restarts.
    const onLose = (): void => this.#session?.send({ kind: "lose-device" });
    this.addEventListener("crease-lose-device", onLose);
    this.#letGo.push(() => this.removeEventListener("crease-lose-device", onLose));
    this.#controlCamera();
    this.#reopen();
  }

  disconnectedCallback(): void {
    for (const letGo of this.#letGo) letGo();
    this.#letGo = [];
    this.#letCameraGo?.();
    this.#letCameraGo = null;
    this.#close();
  }

  attributeChangedCallback(name: string, before: string | null, after: string | null): void {
    if (before === after) return;
    switch (name) {
      case "src":
        this.#reopen();
        break;
      case "motion":
      case "fps":
        this.#currentTime = 0;
        // Both may change at once: one load for both.
        queueMicrotask(() => this.#change({ motion: this.#motionSource() }));
        break;
      case "loop":
        this.#change({ loop: this.loop });
        break;
      case "view":
        this.#change({ view: this.view });
        break;
      case "detail":
        this.#change({ detail: this.detail });
        break;
      case "theme":
        this.#change({ theme: this.#themeNow() });
        break;
      case "alt":
        this.#describe();
        break;
      case "camera-controls":
        this.#controlCamera();
        break;
      case "backend":
        this.#change({ backend: this.backend });
        break;
      case "quality":
        this.#change({ quality: this.quality });
        break;
    }
  }

  /** Resolves at the first picture of the current `src`; rejects with a {@link CreaseError}. */
  get ready(): Promise<void> {
    return this.#ready;
  }

  /** The last error since `src` was set. */
  get error(): CreaseError | null {
    return this.#error;
  }

  /** What was drawn, how fast, by what. */
  get statistics(): Statistics {
    return this.#session?.counter.statistics() ?? this.#statistics ?? new FrameCounter().statistics();
  }

  /** The backend at work; null before there is one. */
  get currentBackend(): Backend | null {
    return this.#session?.counter.backend ?? null;
  }

  /** Starts the motion. */
  play(): void {
    this.#setPlaying(true);
    this.#change({ playing: true });
  }

  /** Stops it where it is. */
  pause(): void {
    this.#setPlaying(false);
    this.#change({ playing: false });
  }

  /** Whether time stands. */
  get paused(): boolean {
    return !this.#playing;
  }

  /** Seconds since the motion's start. */
  get currentTime(): number {
    return this.#currentTime;
  }
  set currentTime(seconds: number) {
    this.#currentTime = seconds;
    this.#session?.send({ kind: "seek", seconds });
  }

  /** Length of the motion, seconds; 0 before it is loaded. */
  get duration(): number {
    return this.#duration;
  }

  /** Seconds of motion per second. */
  get playbackRate(): number {
    return this.#playbackRate;
  }
  set playbackRate(value: number) {
    this.#playbackRate = value;
    this.#change({ playbackRate: value });
  }

  /** Goes back to the first view. */
  resetCamera(): void {
    this.#session?.moveCamera({ kind: "reset" });
  }

  #describe(): void {
    this.setAttribute("aria-label", this.alt ?? "A dressed person in motion");
  }

  #themeNow(): Theme {
    if (this.theme !== "auto") return this.theme;
    return matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  }

  #motionSource(): MotionSource | null {
    const { motion } = this;
    if (motion === null || motion === "") return null;
    return { url: new URL(motion, document.baseURI).href, framesPerSecond: this.fps };
  }

  #settings(): Settings {
    return {
      view: this.view,
      detail: this.detail,
      theme: this.#themeNow(),
      playing: this.#playing,
      loop: this.loop,
      playbackRate: this.#playbackRate,
      motion: this.#motionSource(),
      backend: this.backend,
      quality: this.quality,
    };
  }

  #change(settings: Partial<Settings>): void {
    this.#session?.send({ kind: "settings", settings });
  }

  #setPlaying(playing: boolean): void {
    if (playing === this.#playing) return;
    this.#playing = playing;
    this.dispatchEvent(new Event(playing ? "play" : "pause"));
  }

  #controlCamera(): void {
    this.#letCameraGo?.();
    this.#letCameraGo = null;
    if (!this.cameraControls || !this.isConnected) return;
    if (!this.hasAttribute("tabindex")) this.tabIndex = 0;
    this.#letCameraGo = controlCamera(this, (move) => this.#session?.moveCamera(move));
  }

  #tell(event: string, detail: unknown): void {
    this.dispatchEvent(new CustomEvent(event, { detail }));
  }

  #renewReady(): void {
    this.#ready = new Promise((resolve, reject) => {
      this.#settleReady = { resolve, reject };
    });
    // Whoever asks for `ready` hears of a rejection; nobody has to.
    this.#ready.catch(() => {});
  }

  /** Closes what is open and opens `src`, once for all attributes that change together. */
  #reopen(): void {
    if (this.#opening) return;
    this.#opening = true;
    queueMicrotask(() => {
      this.#opening = false;
      this.#close();
      if (this.isConnected && this.src) this.#open(new URL(this.src, document.baseURI).href);
    });
  }

  #open(url: string): void {
    this.#error = null;
    this.#statistics = null;
    this.#renewReady();
    this.#tree.showMessage(null);
    const session = new Session(url, () => this.#settings(), {
      canvas: () => this.#tree.newCanvas(),
      shown: () => this.#tree.showCanvas(),
      progress: ({ phase, loaded, total }) => this.#tell("progress", { phase, loaded, total } satisfies Progress),
      backend: (backend) => this.#tell("backendchange", backend),
      frame: (frame, first) => this.#onFrame(frame, first),
      motion: (duration, notes) => this.#onMotion(duration, notes),
      failed: (failure, fatal) => this.#onFailure(failure, fatal),
    });
    this.#session = session;
    session.send({ kind: "visible", visible: this.#visible });
    if (this.#size) session.send({ kind: "resize", ...this.#size });
    if (this.#currentTime > 0) session.send({ kind: "seek", seconds: this.#currentTime });
  }

  #close(): void {
    if (!this.#session) return;
    this.#statistics = this.#session.counter.statistics();
    this.#session.close();
    this.#session = null;
    this.#tree.removeCanvas();
  }

  #onFrame(frame: Frame, first: boolean): void {
    this.#currentTime = frame.currentTime;
    if (first) {
      this.#settleReady.resolve();
      this.dispatchEvent(new Event("load"));
    }
    const now = performance.now();
    if (frame.ended && this.#playing) {
      this.#setPlaying(false);
      this.dispatchEvent(new Event("ended"));
    }
    if (now - this.#lastTimeUpdate >= TIME_UPDATE_INTERVAL) {
      this.#lastTimeUpdate = now;
      this.dispatchEvent(new Event("timeupdate"));
    }
  }

  #onMotion(duration: number, notes: readonly string[]): void {
    this.#duration = duration;
    this.#tell("durationchange", { duration, notes });
  }

  #onFailure(failure: Failure, fatal: boolean): void {
    const error = new CreaseError(failure.code, failure.message, failure.url);
    this.#error = error;
    if (fatal) {
      this.#settleReady.reject(error);
      this.#close();
      this.#tree.showMessage(error.message);
    }
    this.dispatchEvent(new ErrorEvent("error", { message: error.message, error }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "crease-avatar": CreaseAvatarElement;
  }
}

if (typeof customElements !== "undefined" && !customElements.get("crease-avatar")) {
  customElements.define("crease-avatar", CreaseAvatarElement);
}
