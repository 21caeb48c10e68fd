import { backendOf, clamp, environmentOf, finite, followOf, numberOf, qualityOf, viewOf } from "../options.js";
import type { BackendChoice, Environment, Follow, QualityChoice, Theme, View } from "../protocol.js";
import { TimeAttributes } from "./time-attributes.js";

/** How it looks. */
export class LookAttributes extends TimeAttributes {
  /**
   * What is shown: the `detailed` surface, the pose-dependent `base`, or the skinned `body`; of the detailed surface, its `wireframe` (coarser from
   * afar), its `normals` as colours, or the learned `laplacian` along the normal (red bulges, blue folds in).
   *
   * @attr view
   * @example `avatar.view = "wireframe";`
   */
  get view(): View {
    return viewOf(this.getAttribute("view"));
  }
  set view(value: View) {
    this.reflect("view", value);
  }

  /**
   * Amount of wrinkles, 0 to 2: 0 is the base, 1 as trained, 2 exaggerated.
   *
   * @attr detail
   * @example `<crease-avatar src="avatar.glb" detail="1.5"></crease-avatar>`
   */
  get detail(): number {
    return clamp(numberOf(this.getAttribute("detail"), 1), 0, 2);
  }
  set detail(value: number) {
    this.reflect("detail", clamp(finite(value, "detail"), 0, 2));
  }

  /**
   * What poses far from those of the training wear, 0 to 1: 1 the folds of the nearest of them, so that cloth looks like cloth in any dance; 0 what
   * is likeliest, which is nearer to the truth in the mean, and smooth. Avatars made of networks know no difference.
   *
   * @attr liveliness
   * @example `<crease-avatar src="avatar.glb" liveliness="0.5"></crease-avatar>`
   */
  get liveliness(): number {
    return clamp(numberOf(this.getAttribute("liveliness"), 1), 0, 1);
  }
  set liveliness(value: number) {
    this.reflect("liveliness", clamp(finite(value, "liveliness"), 0, 1));
  }

  /**
   * Colours around the figure; `auto` follows the page's preference.
   *
   * @attr theme
   * @example `<crease-avatar src="avatar.glb" theme="dark"></crease-avatar>`
   */
  get theme(): Theme | "auto" {
    const theme = this.getAttribute("theme");
    return theme === "light" || theme === "dark" ? theme : "auto";
  }
  set theme(value: Theme | "auto") {
    this.reflect("theme", value);
  }

  /**
   * Any CSS colour behind the figure; `transparent` lets the page show through. The theme's own without it.
   *
   * @attr background
   * @example `<crease-avatar src="avatar.glb" background="transparent"></crease-avatar>`
   */
  get background(): string | null {
    return this.getAttribute("background");
  }
  set background(value: string | null) {
    this.reflect("background", value);
  }

  /**
   * Light on the figure: `studio`, `daylight`, `sunset` or `night`.
   *
   * @attr environment
   * @example `<crease-avatar src="avatar.glb" environment="sunset"></crease-avatar>`
   */
  get environment(): Environment {
    return environmentOf(this.getAttribute("environment"));
  }
  set environment(value: Environment) {
    this.reflect("environment", value);
  }

  /**
   * Strength of the shadow on the floor, 0 to 1.
   *
   * @attr shadow
   * @example `<crease-avatar src="avatar.glb" shadow="0.4"></crease-avatar>`
   */
  get shadow(): number {
    return clamp(numberOf(this.getAttribute("shadow"), 1), 0, 1);
  }
  set shadow(value: number) {
    this.reflect("shadow", clamp(finite(value, "shadow"), 0, 1));
  }

  /**
   * Whether mouse, touch and keys move the camera, and keys move time: arrows orbit, `+` and `-` zoom, space plays and pauses, comma and
   * point step through frames.
   *
   * @attr camera-controls
   * @example `<crease-avatar src="avatar.glb" camera-controls></crease-avatar>`
   */
  get cameraControls(): boolean {
    return this.hasAttribute("camera-controls");
  }
  set cameraControls(value: boolean) {
    this.toggleAttribute("camera-controls", value);
  }

  /**
   * Where the camera is: azimuth (0 is the figure's front), angle from the zenith, and distance, each with its unit or `auto`.
   *
   * @attr camera-orbit
   * @example `<crease-avatar src="avatar.glb" camera-orbit="45deg 80deg 4m"></crease-avatar>`
   */
  get cameraOrbit(): string | null {
    return this.getAttribute("camera-orbit");
  }
  set cameraOrbit(value: string | null) {
    this.reflect("camera-orbit", value);
  }

  /**
   * What the camera looks at, relative to the floor under the figure (see `follow`): three lengths, or `auto`.
   *
   * @attr camera-target
   * @example `<crease-avatar src="avatar.glb" camera-target="0m 1.5m 0m" camera-orbit="auto auto 1.5m"></crease-avatar>`
   */
  get cameraTarget(): string | null {
    return this.getAttribute("camera-target");
  }
  set cameraTarget(value: string | null) {
    this.reflect("camera-target", value);
  }

  /**
   * Vertical field of view, from 5deg to 120deg, or `auto`.
   *
   * @attr field-of-view
   * @example `<crease-avatar src="avatar.glb" field-of-view="20deg"></crease-avatar>`
   */
  get fieldOfView(): string | null {
    return this.getAttribute("field-of-view");
  }
  set fieldOfView(value: string | null) {
    this.reflect("field-of-view", value);
  }

  /**
   * Whether the camera goes round the figure by itself. Not where reduced motion is preferred.
   *
   * @attr auto-rotate
   * @example `<crease-avatar src="avatar.glb" auto-rotate></crease-avatar>`
   */
  get autoRotate(): boolean {
    return this.hasAttribute("auto-rotate");
  }
  set autoRotate(value: boolean) {
    this.toggleAttribute("auto-rotate", value);
  }

  /**
   * Milliseconds for which `auto-rotate` rests after the camera was moved; 3000 unless set.
   *
   * @attr auto-rotate-delay
   * @example `<crease-avatar src="avatar.glb" auto-rotate auto-rotate-delay="500"></crease-avatar>`
   */
  get autoRotateDelay(): number {
    return Math.max(numberOf(this.getAttribute("auto-rotate-delay"), 3000), 0);
  }
  set autoRotateDelay(value: number) {
    this.reflect("auto-rotate-delay", Math.max(finite(value, "autoRotateDelay"), 0));
  }

  /**
   * How fast `auto-rotate` turns: an angle; `12deg` unless set.
   *
   * @attr rotation-per-second
   * @example `<crease-avatar src="avatar.glb" auto-rotate rotation-per-second="30deg"></crease-avatar>`
   */
  get rotationPerSecond(): string | null {
    return this.getAttribute("rotation-per-second");
  }
  set rotationPerSecond(value: string | null) {
    this.reflect("rotation-per-second", value);
  }

  /**
   * What the camera does when the figure walks: `soft` comes along, `root` (or the attribute alone) keeps the root in the middle, `none`
   * stays.
   *
   * @attr follow
   * @example `<crease-avatar src="avatar.glb" motion="walk.npz" follow autoplay></crease-avatar>`
   */
  get follow(): Follow {
    return followOf(this.getAttribute("follow"));
  }
  set follow(value: Follow) {
    this.reflect("follow", value);
  }

  /**
   * What shall compute and draw: `auto` is the fastest that works; one by name (`webgpu`, `webgpu+cpu`, `webgl2+cpu`) falls to the next one
   * where it does not work.
   *
   * @attr backend
   * @example `<crease-avatar src="avatar.glb" backend="webgl2+cpu"></crease-avatar>`
   */
  get backend(): BackendChoice {
    return backendOf(this.getAttribute("backend"));
  }
  set backend(value: BackendChoice) {
    this.reflect("backend", value);
  }

  /**
   * How finely it is posed and drawn: `auto` follows the machine; `best`, `high`, `medium`, `low` or `lowest` is kept, and gives the same
   * picture each time.
   *
   * @attr quality
   * @example `<crease-avatar src="avatar.glb" quality="best"></crease-avatar>`
   */
  get quality(): QualityChoice {
    return qualityOf(this.getAttribute("quality"));
  }
  set quality(value: QualityChoice) {
    this.reflect("quality", value);
  }
}
