/** The element's own tree: a canvas, and a plain message in its place where nothing can be drawn. */
export class ShadowTree {
  readonly #root: ShadowRoot;
  #canvas: HTMLCanvasElement | null = null;

  constructor(host: HTMLElement) {
    this.#root = host.attachShadow({ mode: "open" });
    const style = document.createElement("style");
    style.textContent = `
      :host { display: block; position: relative; overflow: hidden; contain: content; min-block-size: 1px; outline-offset: -2px; }
      :host([hidden]) { display: none; }
      :host([camera-controls]) { cursor: grab; touch-action: pan-y; user-select: none; -webkit-user-select: none; }
      :host([camera-controls]:active) { cursor: grabbing; }
      canvas { position: absolute; inset: 0; inline-size: 100%; block-size: 100%; opacity: 0; transition: opacity 0.35s; }
      canvas.shown { opacity: 1; }
      canvas.at-once { transition: none; }
      .message { position: absolute; inset: 0; display: none; place-content: center; padding: 1.5rem; text-align: center; }
      .message.shown { display: grid; gap: 0.75rem; }
      .message p { margin: 0; max-inline-size: 32rem; }
      @media (prefers-reduced-motion: reduce) { canvas { transition: none; } }`;
    const message = document.createElement("div");
    message.className = "message";
    message.setAttribute("part", "message");
    const reason = document.createElement("p");
    const fallback = document.createElement("slot");
    fallback.name = "fallback";
    message.append(reason, fallback);
    this.#root.append(style, message);
  }

  /** A new canvas; one canvas serves one painter only. The last picture stays until there is one on the new canvas. */
  newCanvas(): HTMLCanvasElement {
    if (this.#canvas && !this.#canvas.classList.contains("shown")) this.#canvas.remove();
    this.#canvas = document.createElement("canvas");
    this.#canvas.setAttribute("aria-hidden", "true");
    this.#root.append(this.#canvas);
    return this.#canvas;
  }

  /** Takes all canvases away. */
  removeCanvas(): void {
    for (const canvas of this.#root.querySelectorAll("canvas")) canvas.remove();
    this.#canvas = null;
  }

  /** Shows the newest canvas once there is a picture on it, in place of older ones. */
  showCanvas(): void {
    for (const canvas of this.#root.querySelectorAll("canvas")) {
      if (canvas === this.#canvas) continue;
      canvas.remove();
      // Where there was a picture already, the next one needs no entrance.
      this.#canvas?.classList.add("at-once");
    }
    this.#canvas?.classList.add("shown");
  }

  /** Shows `text` and the fallback slot, or neither. */
  showMessage(text: string | null): void {
    const message = this.#root.querySelector(".message");
    const reason = message?.querySelector("p");
    message?.classList.toggle("shown", text !== null);
    if (reason) reason.textContent = text;
  }
}
