import type { TypedListeners } from "./events.js";

/** Where there is no DOM (on a server) the class can still be imported. */
const Base = (typeof HTMLElement === "undefined" ? class {} : HTMLElement) as new () => TypedListeners & HTMLElement;

/** An element whose properties are attributes. */
export class ReflectingElement extends Base {
  /** Sets an attribute, or removes it. */
  protected reflect(name: string, value: string | number | null | undefined): void {
    if (value === null || value === undefined) this.removeAttribute(name);
    else this.setAttribute(name, String(value));
  }
}
