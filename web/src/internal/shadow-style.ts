const CSS = `
  :host {
    display: block; position: relative; overflow: hidden; contain: content; min-block-size: 1px;
    --progress: 0;
  }
  :host([hidden]) { display: none; }
  .picture, .poster, .message, .controls { position: absolute; inset: 0; }
  .picture { outline-offset: -3px; }
  .picture:focus-visible { outline: var(--focus-ring, 2px solid Highlight); }
  .picture.controlled { cursor: grab; touch-action: var(--touch-action, pan-y); user-select: none; -webkit-user-select: none; }
  .picture.controlled:active { cursor: grabbing; }
  /* While the element changes its size the picture of the old size is cut, not stretched. */
  canvas {
    position: absolute; inset: 0; inline-size: 100%; block-size: 100%; object-fit: cover; pointer-events: none;
    opacity: 0; transition: opacity 0.35s;
  }
  canvas.shown { opacity: 1; }
  canvas.at-once { transition: none; }
  .poster { background: var(--poster-color, transparent); transition: opacity 0.35s; }
  .poster.gone { opacity: 0; visibility: hidden; pointer-events: none; transition: opacity 0.35s, visibility 0s 0.35s; }
  .poster img { inline-size: 100%; block-size: 100%; object-fit: contain; }
  .poster img:not([src]) { display: none; }
  .progress { position: absolute; inset-inline: 0; inset-block-start: 0; pointer-events: none; transition: opacity 0.35s; }
  .progress.gone { opacity: 0; visibility: hidden; }
  .bar { block-size: var(--progress-bar-height, 3px); background: var(--progress-bar-track-color, transparent); }
  .bar > div {
    block-size: 100%; background: var(--progress-bar-color, rgb(110 130 170 / 0.8));
    transform: scaleX(var(--progress)); transform-origin: left;
  }
  .message { display: none; place-content: center; padding: 1.5rem; text-align: center; overflow: auto; }
  .message.shown { display: grid; gap: 0.75rem; }
  .message p { margin: 0; max-inline-size: 32rem; overflow-wrap: anywhere; }
  .controls { pointer-events: none; display: grid; align-items: end; }
  .controls ::slotted(*), .transport { pointer-events: auto; }
  :host(:not([controls])) .transport, .transport.gone { display: none; }
  .transport {
    display: flex; align-items: center; gap: 0.6rem; padding: 1.6rem 0.8rem 0.5rem; color: var(--transport-color, white);
    font: 0.8rem/1 system-ui, sans-serif; background: linear-gradient(transparent, var(--transport-background, rgb(0 0 0 / 0.55)));
  }
  .transport input { flex: 1; min-inline-size: 0; margin: 0; accent-color: currentcolor; cursor: pointer; }
  .transport :focus-visible { outline: var(--focus-ring, 2px solid currentcolor); outline-offset: 2px; }
  .time { font-variant-numeric: tabular-nums; }
  .play { inline-size: 2rem; block-size: 2rem; padding: 0.5rem; border: 0; border-radius: 50%; background: none; color: inherit; cursor: pointer; }
  .play::before { content: ""; display: block; block-size: 100%; background: currentcolor; clip-path: polygon(12% 0, 100% 50%, 12% 100%); }
  .play.playing::before { clip-path: polygon(10% 0, 38% 0, 38% 100%, 62% 100%, 62% 0, 90% 0, 90% 100%, 10% 100%); }
  .status { position: absolute; inline-size: 1px; block-size: 1px; overflow: hidden; clip-path: inset(50%); white-space: nowrap; }
  @media (prefers-reduced-motion: reduce) { canvas, .poster, .poster.gone, .progress { transition: none; } }`;

let sheet: CSSStyleSheet | undefined;

/** The style of every element's own tree. Made by script, so that a page that forbids inline styles keeps it. */
export function shadowStyle(): CSSStyleSheet {
  if (!sheet) {
    sheet = new CSSStyleSheet();
    sheet.replaceSync(CSS);
  }
  return sheet;
}
