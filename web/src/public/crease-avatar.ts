import { controlPicture } from "../internal/camera-controls.js";
import { CameraOrbit, CameraTarget } from "../internal/camera-place.js";
import { CreaseError } from "../internal/crease-error.js";
import type { CreaseAvatarEventMap } from "../internal/element/events.js";
import { LookAttributes } from "../internal/element/look-attributes.js";
import {
  prefersReducedMotion,
  SETTINGS_OF_ATTRIBUTES,
  type SettingName,
  settingsOf,
} from "../internal/element/settings.js";
import { MediaState } from "../internal/media-state.js";
import { absolute, addressesOf, clamp, finite } from "../internal/options.js";
import type {
  Backend,
  BackendChoice,
  CameraMove,
  CameraPlace,
  Environment,
  ErrorCode,
  Failure,
  Follow,
  Frame,
  MeshFormat,
  QualityChoice,
  Request,
  Settings,
  Theme,
  View,
} from "../internal/protocol.js";
import { Readiness } from "../internal/readiness.js";
import { type Progress, Session } from "../internal/session.js";
import { ShadowTree } from "../internal/shadow.js";
import { FrameCounter, type Statistics } from "../internal/statistics.js";
import { watchSize, watchVisibility } from "../internal/visibility.js";

export type {
  Backend,
  BackendChoice,
  CreaseAvatarEventMap,
  Environment,
  ErrorCode,
  Follow,
  MeshFormat,
  Progress,
  QualityChoice,
  Statistics,
  Theme,
  View,
};
export { CameraOrbit, CameraTarget, CreaseError };

/** Longest side of the picture, pixels. */
const LONGEST_SIDE = 3840;
/** What a step through a motion without a rate moves by, seconds. */
const USUAL_FRAME_SECONDS = 1 / 30;
/** Numbers of a live pose: three for each of SMPL's 24 joints. */
const POSE_NUMBERS = 72;

/** A stretch of time, as in `HTMLMediaElement.seekable`. */
export interface TimeRangesLike {
  readonly length: number;
  /** Seconds at which range `index` starts. */
  start(index: number): number;
  /** Seconds at which it ends. */
  end(index: number): number;
}

/** How a picture is to be encoded. */
export interface PictureOptions {
  /** Media type: `image/png` unless set; `image/jpeg` and `image/webp` where the browser has them. */
  readonly type?: string;
  /** 0 to 1, for types that lose something. */
  readonly quality?: number;
  /** Pixels; the element's own size unless both are set. */
  readonly width?: number;
  readonly height?: number;
}

/** How a film is to be made. */
export interface RecordOptions {
  /** Length; to the end of the motion unless set. */
  readonly seconds?: number;
  /** Pictures a second; 30 unless set. */
  readonly fps?: number;
  /** Bits a second; chosen by the size of the picture unless set. */
  readonly bitsPerSecond?: number;
  /** Pixels; the element's own size unless both are set. */
  readonly width?: number;
  readonly height?: number;
}

/**
 * `<crease-avatar>`: an avatar that moves, and whose clothes wrinkle with its pose.
 *
 * @tag crease-avatar
 * @fires progress - How far the load is: `detail` is a {@link Progress}, `{ phase, loaded, total }`, in bytes.
 * @fires load - The first picture is on the screen.
 * @fires error - Something failed: `error` is a {@link CreaseError}, with `code`, `message` and `url`.
 * @fires backendchange - `detail` is the {@link Backend} now at work.
 * @fires play - Time starts.
 * @fires pause - Time stops.
 * @fires timeupdate - Time has gone on: up to four times a second, and at every stop.
 * @fires seeking - `currentTime` was set.
 * @fires seeked - The picture of that time is on the screen.
 * @fires ended - A motion that does not loop has come to its end.
 * @fires ratechange - `playbackRate` has changed.
 * @fires durationchange - Another motion is there: `detail` is `{ duration, notes }`, what its reader has to say.
 * @fires camera-change - The camera has moved.
 * @fires poster-dismissed - The poster is gone.
 * @slot poster - Covers the picture until it is revealed, in place of the picture at `poster`.
 * @slot progress-bar - Shown while the avatar loads, in place of the bar.
 * @slot controls - Lies over the lower edge of the picture, in place of the bar of `controls`.
 * @slot fallback - Shown under the reason where the avatar cannot be shown.
 * @csspart picture - What is drawn, focused and steered.
 * @csspart poster - The poster's image.
 * @csspart progress-bar - The bar, and `progress-value` in it.
 * @csspart message - What is shown after an error, and `reason` in it.
 * @csspart controls - What holds the slot `controls`.
 * @csspart transport - The bar of `controls`; `play`, `scrub` and `time` in it.
 * @cssprop --poster-color - Behind the poster.
 * @cssprop --progress-bar-color - The bar.
 * @cssprop --progress-bar-track-color - Behind the bar.
 * @cssprop --progress-bar-height - Its height.
 * @cssprop --transport-color - The bar of `controls`.
 * @cssprop --transport-background - Behind it.
 * @cssprop --focus-ring - The picture's outline while it has the focus of the keyboard.
 * @cssprop --touch-action - What a touch may do to the page while `camera-controls` are on; `pan-y` unless set.
 * @example `<crease-avatar src="avatar.glb" motion="dance.pkl" fps="60" autoplay loop camera-controls></crease-avatar>`
 */
export class CreaseAvatarElement extends LookAttributes {
  static readonly observedAttributes = [
    "src",
    "loading",
    "alt",
    "poster",
    "camera-controls",
    ...Object.keys(SETTINGS_OF_ATTRIBUTES),
  ];

  readonly #tree: ShadowTree;
  readonly #media: MediaState;
  readonly #readiness = new Readiness();
  readonly #changed = new Set<SettingName>();
  #session: Session | null = null;
  #letGo: (() => void)[] = [];
  #letCameraGo: (() => void) | null = null;
  #opening = false;
  #error: CreaseError | null = null;
  #playbackRate = 1;
  #framesPerSecond = 0;
  #motionIndex = 0;
  #camera: CameraPlace | null = null;
  #pose: Float32Array | null = null;
  #translation: Float32Array | null = null;
  #statistics: Statistics | null = null;
  #size: { width: number; height: number } | null = null;
  #visible = false;
  /** It has been near the part of the page that can be seen. */
  #seen = false;
  #started = false;

  constructor() {
    super();
    this.#media = new MediaState({
      tell: (event) => this.dispatchEvent(new Event(event)),
      wish: (wish) => this.#session?.send({ kind: "clock", wish }),
    });
    this.#tree = new ShadowTree(this);
    this.#tree.poster.addEventListener("click", () => {
      if (this.reveal === "interaction") this.dismissPoster();
    });
  }

  connectedCallback(): void {
    this.#describe();
    if (!this.#started && this.autoplay && !prefersReducedMotion()) this.#media.play();
    this.#started = true;
    const colours = matchMedia("(prefers-color-scheme: dark)");
    const onColours = (): void => this.#change("theme");
    colours.addEventListener("change", onColours);
    this.#letGo = [
      () => colours.removeEventListener("change", onColours),
      watchVisibility(this, (visible) => this.#onVisible(visible)),
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
    // An element that was only moved goes on with what it has.
    if (!this.#session) this.#reopen();
  }

  disconnectedCallback(): void {
    for (const letGo of this.#letGo) letGo();
    this.#letGo = [];
    this.#letCameraGo?.();
    this.#letCameraGo = null;
    queueMicrotask(() => {
      if (!this.isConnected) this.#close();
    });
  }

  /** Moved within the page by `moveBefore()`: nothing changes. */
  connectedMoveCallback(): void {}

  attributeChangedCallback(name: string, before: string | null, after: string | null): void {
    // The same address again is another try.
    if (before === after && !this.#hasFailed(name, after)) return;
    const setting = SETTINGS_OF_ATTRIBUTES[name];
    if (setting) this.#change(setting);
    switch (name) {
      case "src":
        this.#reopen();
        break;
      case "loading":
        if (!this.#session) this.#reopen();
        break;
      case "motion":
        this.#media.restart();
        break;
      case "playback-rate":
        if (this.playbackRate === this.#playbackRate) break;
        this.#playbackRate = this.playbackRate;
        this.dispatchEvent(new Event("ratechange"));
        break;
      case "poster":
        this.#tree.setPoster(this.poster);
        break;
      case "alt":
        this.#describe();
        break;
      case "camera-controls":
        this.#describe();
        this.#controlCamera();
        break;
    }
  }

  #hasFailed(name: string, addresses: string | null): boolean {
    if (name !== "motion") return name === "src" && this.#error !== null;
    return addressesOf(addresses).some((address) => absolute(address) === this.#error?.url);
  }

  /**
   * Resolves at the first picture of the current `src`; rejects with a {@link CreaseError}.
   *
   * @example `await document.querySelector("crease-avatar").ready;`
   */
  get ready(): Promise<void> {
    return this.#readiness.promise;
  }

  /**
   * Whether the first picture of the current `src` has been drawn.
   *
   * @example `if (!avatar.loaded) await avatar.ready;`
   */
  get loaded(): boolean {
    return this.#readiness.loaded;
  }

  /**
   * The last error since `src` was set.
   *
   * @example `if (avatar.error?.code === "network") offerRetry();`
   */
  get error(): CreaseError | null {
    return this.#error;
  }

  /**
   * What was drawn, how fast, by what, with how much memory.
   *
   * @example `const { frameMilliseconds, vertices } = avatar.statistics;`
   */
  get statistics(): Statistics {
    return this.#session?.counter.statistics() ?? this.#statistics ?? new FrameCounter().statistics();
  }

  /**
   * The backend at work; null before there is one.
   *
   * @example `avatar.addEventListener("backendchange", () => console.log(avatar.currentBackend));`
   */
  get currentBackend(): Backend | null {
    return this.#session?.counter.backend ?? null;
  }

  /**
   * Starts the motion; from its beginning if it has ended. The promise is {@link ready}.
   *
   * @example `button.onclick = () => avatar.play();`
   */
  play(): Promise<void> {
    this.#media.play();
    return this.#readiness.promise;
  }

  /**
   * Stops it where it is.
   *
   * @example `avatar.pause();`
   */
  pause(): void {
    this.#media.pause();
  }

  /**
   * Whether time stands.
   *
   * @example `avatar.paused ? avatar.play() : avatar.pause();`
   */
  get paused(): boolean {
    return this.#media.paused;
  }

  /**
   * Whether a motion that does not loop has come to its end.
   *
   * @example `if (avatar.ended) avatar.play();`
   */
  get ended(): boolean {
    return this.#media.ended;
  }

  /**
   * Whether the picture of the time that was set last is not on the screen yet.
   *
   * @example `spinner.hidden = !avatar.seeking;`
   */
  get seeking(): boolean {
    return this.#media.seeking;
  }

  /**
   * Seconds since the start of the motion, or of the whole playlist. Setting it goes there, clamped to the motion.
   *
   * @example `avatar.currentTime = 2.5;`
   */
  get currentTime(): number {
    return this.#media.currentTime;
  }
  set currentTime(seconds: number) {
    this.#media.seek(finite(seconds, "currentTime"));
  }

  /**
   * Length of the motion, or of the whole playlist, seconds; NaN before it is known, 0 where there is none.
   *
   * @example `avatar.addEventListener("durationchange", () => { slider.max = avatar.duration; });`
   */
  get duration(): number {
    return this.#media.duration;
  }

  /**
   * The times that `currentTime` can be set to: all of the motion.
   *
   * @example `const last = avatar.seekable.end(0);`
   */
  get seekable(): TimeRangesLike {
    const { duration } = this.#media;
    const length = duration > 0 ? 1 : 0;
    const at = (seconds: number) => (index: number) => {
      if (index >= 0 && index < length) return seconds;
      throw new RangeError(`seekable: expected an index below ${length}, found ${index}`);
    };
    return { length, start: at(0), end: at(duration) };
  }

  /**
   * Which motion of the playlist is shown, counted from 0.
   *
   * @example `const playing = avatar.motion.split(" ")[avatar.motionIndex];`
   */
  get motionIndex(): number {
    return this.#motionIndex;
  }

  /**
   * Stops, and goes so many frames of the motion on, or back.
   *
   * @example `avatar.stepFrames(-1);`
   */
  stepFrames(frames: number): void {
    this.pause();
    const seconds = this.#framesPerSecond > 0 ? 1 / this.#framesPerSecond : USUAL_FRAME_SECONDS;
    this.currentTime = Math.max(this.currentTime + finite(frames, "frames") * seconds, 0);
  }

  /**
   * A pose in place of the motion: three axis-angle numbers, radians, for each of SMPL's 24 joints. Set it as often as you like; the
   * array is read at once. Null gives the motion back. See `smoothing`.
   *
   * @example `const pose = new Float32Array(72); pose[1] = Math.PI / 2; avatar.pose = pose;`
   */
  get pose(): Float32Array | null {
    return this.#pose?.slice() ?? null;
  }
  set pose(value: ArrayLike<number> | null) {
    this.#pose = value === null ? null : numbersOf(value, POSE_NUMBERS, "pose");
    this.#sendPose();
  }

  /**
   * Where the root of a live `pose` is: x, y and z, metres, added to every vertex. Null puts the feet of the rest pose on the floor.
   *
   * @example `avatar.translation = [0, 0.95, 0];`
   */
  get translation(): Float32Array | null {
    return this.#translation?.slice() ?? null;
  }
  set translation(value: ArrayLike<number> | null) {
    this.#translation = value === null ? null : numbersOf(value, 3, "translation");
    if (this.#pose) this.#sendPose();
  }

  /**
   * Goes back to the first view, the one of `camera-orbit`, `camera-target` and `field-of-view`.
   *
   * @example `homeButton.onclick = () => avatar.resetCamera();`
   */
  resetCamera(): void {
    this.#session?.moveCamera({ kind: "reset" });
  }

  /**
   * Ends a movement of the camera at once.
   *
   * @example `avatar.cameraOrbit = "90deg 80deg 3m"; avatar.jumpCameraToGoal();`
   */
  jumpCameraToGoal(): void {
    this.#flush();
    this.#session?.moveCamera({ kind: "jump" });
  }

  /**
   * Where the camera is about its target now; its text is what `camera-orbit` takes.
   *
   * @example `link.searchParams.set("orbit", avatar.getCameraOrbit().toString());`
   */
  getCameraOrbit(): CameraOrbit {
    const { azimuth = 0, elevation = 0, distance = 0 } = this.#camera ?? {};
    return new CameraOrbit(azimuth, Math.PI / 2 - elevation, distance);
  }

  /**
   * What the camera looks at now, metres, relative to the floor under the figure; its text is what `camera-target` takes.
   *
   * @example `link.searchParams.set("target", avatar.getCameraTarget().toString());`
   */
  getCameraTarget(): CameraTarget {
    const [x, y, z] = this.#camera?.target ?? [0, 0, 0];
    return new CameraTarget(x, y, z);
  }

  /**
   * The vertical field of view now, degrees.
   *
   * @example `console.log(avatar.getFieldOfView());`
   */
  getFieldOfView(): number {
    return ((this.#camera?.fieldOfView ?? 0) * 180) / Math.PI;
  }

  /**
   * Takes the poster away.
   *
   * @example `button.onclick = () => avatar.dismissPoster();`
   */
  dismissPoster(): void {
    this.#tree.showPoster(false);
    this.dispatchEvent(new Event("poster-dismissed"));
  }

  /**
   * Shows the poster over the picture.
   *
   * @example `avatar.showPoster();`
   */
  showPoster(): void {
    this.#tree.showPoster(true);
  }

  /**
   * The present picture as a file.
   *
   * @example `const blob = await avatar.toBlob({ type: "image/webp", width: 512, height: 512 });`
   */
  async toBlob(options: PictureOptions = {}): Promise<Blob> {
    const { type = "image/png", quality = null } = options;
    return (await this.#request({ kind: "picture", wish: { type, quality, size: sizeOf(options) } })) as Blob;
  }

  /**
   * The present picture as a `data:` address.
   *
   * @example `image.src = await avatar.toDataURL("image/jpeg", 0.8);`
   */
  async toDataURL(type = "image/png", quality?: number): Promise<string> {
    const blob = await this.toBlob(quality === undefined ? { type } : { type, quality });
    return new Promise((resolve, reject) => {
      const reader = new FileReader();
      reader.onload = () => resolve(reader.result as string);
      reader.onerror = () => reject(reader.error);
      reader.readAsDataURL(blob);
    });
  }

  /**
   * The present mesh as a file, at its finest: `glb` with its texture, `obj` and `ply` with texture coordinates and the texture's colours
   * at the vertices.
   *
   * @example `const blob = await avatar.exportMesh({ format: "obj" });`
   */
  async exportMesh({ format = "glb" }: { readonly format?: MeshFormat } = {}): Promise<Blob> {
    if (!["glb", "obj", "ply"].includes(format)) {
      throw new TypeError(`format: expected glb, obj or ply, found ${format}`);
    }
    return (await this.#request({ kind: "mesh", format })) as Blob;
  }

  /**
   * Stops at `seconds` and draws that moment as it always looks, whatever was before: at its finest quality unless `quality` says
   * otherwise, with the camera at rest. Resolves when the picture is drawn.
   *
   * @example `await avatar.renderFrame(1.5); const blob = await avatar.toBlob();`
   */
  async renderFrame(seconds: number): Promise<void> {
    const moment = Math.max(finite(seconds, "renderFrame"), 0);
    await this.#readiness.promise;
    await this.#request({ kind: "render-frame", seconds: moment, order: this.#media.hold(moment) });
  }

  /**
   * Films the motion from where it is, every frame at its exact moment however long it takes to draw; then goes on as before. WebM with VP9
   * or VP8, through WebCodecs.
   *
   * @example `const blob = await avatar.record({ seconds: 4, fps: 30 });`
   */
  async record(options: RecordOptions = {}): Promise<Blob> {
    const fps = clamp(finite(options.fps ?? 30, "fps"), 1, 240);
    const rest = this.duration > this.currentTime ? this.duration - this.currentTime : 1;
    const seconds = clamp(finite(options.seconds ?? rest, "seconds"), 1 / fps, 3600);
    const { bitsPerSecond = null } = options;
    const request = { kind: "record", seconds, framesPerSecond: fps, bitsPerSecond, size: sizeOf(options) } as const;
    return (await this.#request(request)) as Blob;
  }

  /** Asks the stage, once there is a picture and all that was set before is on its way. */
  async #request(request: Request): Promise<Blob | undefined> {
    await this.#readiness.promise;
    this.#flush();
    const session = this.#session;
    if (!session) throw new CreaseError("canvas", "expected an avatar that is shown, found none", this.src);
    return await session.request(request);
  }

  #describe(): void {
    this.#tree.describe(this.alt ?? "A dressed person in motion", this.cameraControls);
  }

  /** Attributes that change together are told of together. */
  #change(name: SettingName): void {
    if (!this.#session) return;
    if (this.#changed.size === 0) queueMicrotask(() => this.#flush());
    this.#changed.add(name);
  }

  /** Tells the stage what has changed since it was told last. */
  #flush(): void {
    if (this.#changed.size === 0) return;
    const names = [...this.#changed];
    this.#changed.clear();
    const settings = settingsOf(this);
    const changed = Object.fromEntries(names.map((name) => [name, settings[name]])) as Partial<Settings>;
    this.#session?.send({ kind: "settings", settings: changed });
  }

  #sendPose(): void {
    this.#session?.send({ kind: "pose", live: { pose: this.#pose, translation: this.#translation } });
  }

  #onVisible(visible: boolean): void {
    this.#visible = visible;
    this.#session?.send({ kind: "visible", visible });
    if (!visible || this.#seen) return;
    this.#seen = true;
    if (this.loading === "lazy" && !this.#session) this.#reopen();
  }

  #controlCamera(): void {
    this.#letCameraGo?.();
    this.#letCameraGo = null;
    if (!this.cameraControls || !this.isConnected) return;
    this.#letCameraGo = controlPicture(this.#tree.picture, {
      move: (move) => this.#moveCamera(move),
      toggle: () => {
        if (this.paused) this.play();
        else this.pause();
        this.#tree.announce(this.paused ? "Paused" : "Playing");
      },
      step: (frames) => {
        this.stepFrames(frames);
        this.#tree.announce(`${this.currentTime.toFixed(2)} seconds`);
      },
    });
  }

  #moveCamera(move: CameraMove): void {
    this.#session?.moveCamera(move);
  }

  #tell(event: string, detail: unknown): void {
    this.dispatchEvent(new CustomEvent(event, { detail }));
  }

  /** Closes what is open and opens `src`, once for all attributes that change together. */
  #reopen(): void {
    if (this.#opening) return;
    this.#opening = true;
    queueMicrotask(() => {
      this.#opening = false;
      this.#close();
      const mayLoad = this.loading === "eager" || this.#seen;
      if (this.isConnected && this.src && mayLoad) this.#open(absolute(this.src));
      else if (this.isConnected && this.src) this.showPoster();
    });
  }

  #open(url: string): void {
    this.#error = null;
    this.#statistics = null;
    this.#camera = null;
    this.#media.forget();
    this.#readiness.renew();
    this.#tree.showMessage(null);
    this.#tree.showProgress(0);
    this.showPoster();
    const opening = (): { settings: Settings; clock: MediaState["wish"] } => {
      this.#changed.clear();
      return { settings: settingsOf(this), clock: this.#media.wish };
    };
    const session = new Session(url, opening, {
      canvas: () => this.#tree.newCanvas(),
      shown: () => this.#tree.showCanvas(),
      progress: ({ phase, loaded, total }) => {
        if (total) this.#tree.showProgress(loaded / total);
        this.#tell("progress", { phase, loaded, total } satisfies Progress);
      },
      backend: (backend) => this.#tell("backendchange", backend),
      frame: (frame, first) => this.#onFrame(frame, first),
      time: (order, currentTime) => this.#media.hear({ order, currentTime, ended: false }, performance.now()),
      motion: (duration, framesPerSecond, notes) => this.#onMotion(duration, framesPerSecond, notes),
      failed: (failure, fatal) => this.#onFailure(failure, fatal),
    });
    this.#session = session;
    session.send({ kind: "visible", visible: this.#visible });
    if (this.#size) session.send({ kind: "resize", ...this.#size });
    if (this.#pose) this.#sendPose();
  }

  #close(): void {
    if (!this.#session) return;
    this.#statistics = this.#session.counter.statistics();
    this.#session.close();
    this.#session = null;
    this.#tree.removeCanvas();
    this.#tree.showProgress(null);
  }

  #onFrame(frame: Frame, first: boolean): void {
    this.#motionIndex = frame.motionIndex;
    this.#onCamera(frame.camera);
    if (first) {
      this.#tree.showProgress(null);
      if (this.reveal === "auto") this.dismissPoster();
      this.#readiness.resolve();
      this.dispatchEvent(new Event("load"));
    }
    this.#media.hear(frame, performance.now());
  }

  #onCamera(camera: CameraPlace): void {
    const before = this.#camera;
    this.#camera = camera;
    if (before && !sameCamera(before, camera)) this.dispatchEvent(new Event("camera-change"));
  }

  #onMotion(duration: number, framesPerSecond: number, notes: readonly string[]): void {
    this.#framesPerSecond = framesPerSecond;
    this.#media.loaded(duration);
    this.#tell("durationchange", { duration, notes });
  }

  #onFailure(failure: Failure, fatal: boolean): void {
    const error = CreaseError.of(failure);
    this.#error = error;
    if (fatal) {
      this.#readiness.reject(error);
      this.#close();
      this.#tree.showPoster(false);
      this.#tree.showMessage(error.message);
    }
    this.dispatchEvent(new ErrorEvent("error", { message: error.message, error }));
  }
}

function numbersOf(value: ArrayLike<number>, count: number, what: string): Float32Array {
  const numbers = Float32Array.from(value);
  if (numbers.length !== count || !numbers.every(Number.isFinite)) {
    throw new TypeError(`${what}: expected ${count} finite numbers, found ${numbers.length}`);
  }
  return numbers;
}

type Size = { readonly width: number; readonly height: number };

function sizeOf({ width, height }: Partial<Size>): Size | null {
  if (width === undefined || height === undefined) return null;
  const side = (value: number, what: string): number => Math.round(clamp(finite(value, what), 1, LONGEST_SIDE));
  return { width: side(width, "width"), height: side(height, "height") };
}

function sameCamera(a: CameraPlace, b: CameraPlace): boolean {
  return (
    a.azimuth === b.azimuth &&
    a.elevation === b.elevation &&
    a.distance === b.distance &&
    a.fieldOfView === b.fieldOfView &&
    a.target.every((coordinate, axis) => coordinate === b.target[axis])
  );
}

declare global {
  interface HTMLElementTagNameMap {
    "crease-avatar": CreaseAvatarElement;
  }
}

if (typeof customElements !== "undefined" && !customElements.get("crease-avatar")) {
  customElements.define("crease-avatar", CreaseAvatarElement);
}
