import { controlCamera } from "../internal/camera-controls.js";
import { numberOf, viewOf } from "../internal/options.js";
import type { ErrorCode, Failure, Frame, MotionSource, Settings, Theme, View } from "../internal/protocol.js";
import { Session } from "../internal/session.js";
import { ShadowTree } from "../internal/shadow.js";
import type { Statistics } from "../internal/statistics.js";
import { watchSize, watchVisibility } from "../internal/visibility.js";

export type { ErrorCode, Statistics, Theme, View };

/** Why an avatar or a motion cannot be shown. */
export class CreaseError extends Error {
  override readonly name = "CreaseError";
  /** For programs. */
  readonly code: ErrorCode;
  /** The file that it is about. */
  readonly url: string | null;

  constructor(code: ErrorCode, message: string, url: string | null) {
    super(message);
    this.code = code;
    this.url = url;
  }
}

/** Longest side of the picture, pixels. */
const LONGEST_SIDE = 3840;
/** Milliseconds between two `timeupdate` events. */
const TIME_UPDATE_INTERVAL = 250;

/** Where there is no DOM (on a server) the class can still be imported. */
const Base = (typeof HTMLElement === "undefined" ? class {} : HTMLElement) as typeof HTMLElement;

/**
 * `<crease-avatar src motion fps autoplay loop view detail theme alt camera-controls>`: an avatar that moves.
 *
 * Events: `load` (first picture), `error`, `play`, `pause`, `timeupdate`, `ended`, `durationchange`.
 */
export class CreaseAvatarElement extends Base {
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
    const none = { frames: 0, firstFrameMilliseconds: null, frameMilliseconds: null, poseMilliseconds: null };
    const unknown = { ...none, backend: null, thread: null, vertices: 0 };
    return this.#session?.counter.statistics() ?? this.#statistics ?? unknown;
  }

  /** Address of the avatar. */
  get src(): string | null {
    return this.getAttribute("src");
  }
  set src(value: string | null) {
    this.#reflect("src", value);
  }

  /** Address of the motion. */
  get motion(): string | null {
    return this.getAttribute("motion");
  }
  set motion(value: string | null) {
    this.#reflect("motion", value);
  }

  /** Poses a second, for motion files that hold no rate. */
  get fps(): number | null {
    return numberOf(this.getAttribute("fps"), null);
  }
  set fps(value: number | null) {
    this.#reflect("fps", value === null ? null : String(value));
  }

  /** Which surface is shown. */
  get view(): View {
    return viewOf(this.getAttribute("view"));
  }
  set view(value: View) {
    this.#reflect("view", value);
  }

  /** Amount of detail: 0 is the base, 1 as trained, 2 exaggerated. */
  get detail(): number {
    return Math.min(Math.max(numberOf(this.getAttribute("detail"), 1), 0), 2);
  }
  set detail(value: number) {
    this.#reflect("detail", String(value));
  }

  /** Colours around the figure; `auto` follows the page's preference. */
  get theme(): Theme | "auto" {
    const theme = this.getAttribute("theme");
    return theme === "light" || theme === "dark" ? theme : "auto";
  }
  set theme(value: Theme | "auto") {
    this.#reflect("theme", value);
  }

  /** Whether the motion starts over at its end: yes, unless `loop="false"`. */
  get loop(): boolean {
    return this.getAttribute("loop") !== "false";
  }
  set loop(value: boolean) {
    this.#reflect("loop", value ? null : "false");
  }

  /** Whether playing starts by itself. */
  get autoplay(): boolean {
    return this.hasAttribute("autoplay");
  }
  set autoplay(value: boolean) {
    this.toggleAttribute("autoplay", value);
  }

  /** Whether mouse, touch and keys move the camera. */
  get cameraControls(): boolean {
    return this.hasAttribute("camera-controls");
  }
  set cameraControls(value: boolean) {
    this.toggleAttribute("camera-controls", value);
  }

  /** What the picture shows, for people who do not see it. */
  get alt(): string | null {
    return this.getAttribute("alt");
  }
  set alt(value: string | null) {
    this.#reflect("alt", value);
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

  #reflect(name: string, value: string | null): void {
    if (value === null) this.removeAttribute(name);
    else this.setAttribute(name, value);
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
      this.#tree.showCanvas();
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
    this.dispatchEvent(new CustomEvent("durationchange", { detail: { duration, notes } }));
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
