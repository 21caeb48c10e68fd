import type { CameraMove } from "./protocol.js";

/** Radians for a drag across the element's height. */
const TURN = 4;
/** Radians for an arrow key. */
const KEY_TURN = 0.2;

/**
 * Drag orbits, two fingers pinch and pan, a right or shift drag pans, the wheel zooms, arrow keys orbit, a double click goes back.
 * The wheel is left to the page when the page can scroll and the element is not focused. Returns a function that lets go.
 */
export function controlCamera(element: HTMLElement, move: (move: CameraMove) => void): () => void {
  const abort = new AbortController();
  const { signal } = abort;
  const pointers = new Map<number, { x: number; y: number }>();

  element.addEventListener(
    "pointerdown",
    (event) => {
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      element.setPointerCapture(event.pointerId);
    },
    { signal },
  );

  element.addEventListener(
    "pointermove",
    (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const height = Math.max(element.clientHeight, 1);
      const right = (event.clientX - last.x) / height;
      const down = (event.clientY - last.y) / height;
      const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (other) {
        const before = Math.hypot(last.x - other.x, last.y - other.y);
        const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
        if (before > 0 && after > 0) move({ kind: "zoom", factor: before / after });
        move({ kind: "pan", right: -right / 2, up: down / 2 });
      } else if (event.shiftKey || event.buttons === 2) {
        move({ kind: "pan", right: -right, up: down });
      } else {
        move({ kind: "orbit", azimuth: -TURN * right, elevation: TURN * down });
      }
    },
    { signal },
  );

  for (const kind of ["pointerup", "pointercancel"] as const) {
    element.addEventListener(kind, (event) => pointers.delete(event.pointerId), { signal });
  }

  element.addEventListener(
    "wheel",
    (event) => {
      if (!wantsWheel(element, event)) return;
      event.preventDefault();
      const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 * event.deltaY : event.deltaY;
      // A pinch on a touch pad arrives as a wheel with ctrl, in finer steps.
      move({ kind: "zoom", factor: Math.exp((event.ctrlKey ? 0.01 : 0.0015) * pixels) });
    },
    { signal, passive: false },
  );

  element.addEventListener("dblclick", () => move({ kind: "reset" }), { signal });
  element.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });

  element.addEventListener(
    "keydown",
    (event) => {
      const known = keyMove(event.key);
      if (!known || event.target !== element || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      move(known);
    },
    { signal },
  );

  return () => abort.abort();
}

function wantsWheel(element: HTMLElement, event: WheelEvent): boolean {
  const page = document.scrollingElement;
  const pageScrolls = page !== null && page.scrollHeight > page.clientHeight;
  return event.ctrlKey || !pageScrolls || element.matches(":focus");
}

function keyMove(key: string): CameraMove | null {
  switch (key) {
    case "ArrowLeft":
      return { kind: "orbit", azimuth: -KEY_TURN, elevation: 0 };
    case "ArrowRight":
      return { kind: "orbit", azimuth: KEY_TURN, elevation: 0 };
    case "ArrowUp":
      return { kind: "orbit", azimuth: 0, elevation: KEY_TURN };
    case "ArrowDown":
      return { kind: "orbit", azimuth: 0, elevation: -KEY_TURN };
    case "+":
      return { kind: "zoom", factor: 0.85 };
    case "-":
      return { kind: "zoom", factor: 1 / 0.85 };
    default:
      return null;
  }
}
