import { backendOf, numberOf, qualityOf, viewOf } from "./options.js";
import type { BackendChoice, QualityChoice, Theme, View } from "./protocol.js";

/** Where there is no DOM (on a server) the class can still be imported. */
const Base = (typeof HTMLElement === "undefined" ? class {} : HTMLElement) as typeof HTMLElement;

/** The element's attributes as properties. */
export class AttributedElement extends Base {
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

  /** What shall compute and draw: `auto` is the fastest that works; a backend that does not work falls to the next one. */
  get backend(): BackendChoice {
    return backendOf(this.getAttribute("backend"));
  }
  set backend(value: BackendChoice) {
    this.#reflect("backend", value);
  }

  /** How finely it is posed and drawn: `auto` follows the machine; a level by name is kept, and gives the same picture each time. */
  get quality(): QualityChoice {
    return qualityOf(this.getAttribute("quality"));
  }
  set quality(value: QualityChoice) {
    this.#reflect("quality", value);
  }

  #reflect(name: string, value: string | null): void {
    if (value === null) this.removeAttribute(name);
    else this.setAttribute(name, value);
  }
}
