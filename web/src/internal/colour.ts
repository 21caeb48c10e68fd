import type { Colour } from "./protocol.js";

/** A CSS colour as numbers, read by the browser itself; null where it is none. */
export function colourOf(text: string | null): Colour | null {
  const css = text?.trim();
  if (!css || !CSS.supports("color", css)) return null;
  const context = new OffscreenCanvas(1, 1).getContext("2d");
  if (!context) return null;
  context.fillStyle = css;
  context.fillRect(0, 0, 1, 1);
  const [red = 0, green = 0, blue = 0, alpha = 0] = context.getImageData(0, 0, 1, 1).data;
  return [red / 255, green / 255, blue / 255, alpha / 255];
}
