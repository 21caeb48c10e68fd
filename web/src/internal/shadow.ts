import { make } from "./make.js";
import { shadowStyle } from "./shadow-style.js";
import { type Playable, Transport } from "./transport.js";

/** The element's own tree: the picture, and what lies over it: poster, progress bar, message, controls. */
export class ShadowTree {
  /** What is seen, focused and steered. */
  readonly picture = make("div", { class: "picture", part: "picture" });
  /** Whatever covers the picture until it is revealed. */
  readonly poster = make("div", { class: "poster gone" });
  readonly #image = make("img", { part: "poster", alt: "" });
  readonly #progress = make("div", { class: "progress gone" });
  readonly #bar = make("div", {
    class: "bar",
    part: "progress-bar",
    role: "progressbar",
    "aria-label": "Loading",
    "aria-valuemin": "0",
    "aria-valuemax": "100",
  });
  readonly #message = make("div", { class: "message", part: "message", role: "alert" });
  readonly #reason = make("p", { part: "reason" });
  readonly #status = make("div", { class: "status", role: "status" });
  #canvas: HTMLCanvasElement | null = null;

  constructor(host: HTMLElement & Playable) {
    const root = host.attachShadow({ mode: "open", delegatesFocus: true });
    root.adoptedStyleSheets = [shadowStyle()];
    this.#bar.append(make("div", { part: "progress-value" }));
    this.poster.append(slot("poster", this.#image));
    this.#progress.append(slot("progress-bar", this.#bar));
    this.#message.append(this.#reason, slot("fallback"));
    const controls = make("div", { class: "controls", part: "controls" });
    controls.append(slot("controls", new Transport(host).bar));
    root.append(this.picture, this.poster, this.#message, this.#progress, controls, this.#status);
  }

  /** Says what the picture is, and whether it can be steered. */
  describe(label: string, controlled: boolean): void {
    const { picture } = this;
    picture.setAttribute("aria-label", label);
    // Readers of the screen leave arrow keys to an application.
    picture.setAttribute("role", controlled ? "application" : "img");
    picture.classList.toggle("controlled", controlled);
    if (controlled) picture.setAttribute("tabindex", "0");
    else picture.removeAttribute("tabindex");
  }

  /** Tells people who do not see it what has changed. */
  announce(text: string): void {
    this.#status.textContent = text;
  }

  /** Sets the poster's address. */
  setPoster(url: string | null): void {
    if (url) this.#image.setAttribute("src", url);
    else this.#image.removeAttribute("src");
  }

  /** Shows the poster over the picture, or takes it away. */
  showPoster(shown: boolean): void {
    this.poster.classList.toggle("gone", !shown);
  }

  /** Shows how far the load is, 0 to 1; null takes the bar away. */
  showProgress(share: number | null): void {
    this.#progress.classList.toggle("gone", share === null);
    if (share === null) return;
    this.#bar.style.setProperty("--progress", share.toFixed(3));
    this.#bar.setAttribute("aria-valuenow", String(Math.round(100 * share)));
  }

  /** A new canvas; one canvas serves one painter only. The last picture stays until there is one on the new canvas. */
  newCanvas(): HTMLCanvasElement {
    if (this.#canvas && !this.#canvas.classList.contains("shown")) this.#canvas.remove();
    this.#canvas = document.createElement("canvas");
    this.#canvas.setAttribute("aria-hidden", "true");
    this.picture.append(this.#canvas);
    return this.#canvas;
  }

  /** Takes all canvases away. */
  removeCanvas(): void {
    for (const canvas of this.picture.querySelectorAll("canvas")) canvas.remove();
    this.#canvas = null;
  }

  /** Shows the newest canvas once there is a picture on it, in place of older ones. */
  showCanvas(): void {
    for (const canvas of this.picture.querySelectorAll("canvas")) {
      if (canvas === this.#canvas) continue;
      canvas.remove();
      // Where there was a picture already, the next one needs no entrance.
      this.#canvas?.classList.add("at-once");
    }
    this.#canvas?.classList.add("shown");
  }

  /** Shows `text` and the fallback slot, or neither. */
  showMessage(text: string | null): void {
    this.#message.classList.toggle("shown", text !== null);
    this.#reason.textContent = text;
  }
}

function slot(name: string, ...content: readonly HTMLElement[]): HTMLElement {
  const element = make("slot", { name });
  element.append(...content);
  return element;
}
