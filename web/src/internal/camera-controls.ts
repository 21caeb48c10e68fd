import type { CameraMove } from "./protocol.js";

/** Radians for a drag across the picture's height. */
const TURN = 4;
/** Radians for an arrow key. */
const KEY_TURN = 0.2;

/** What people do to a picture. */
export interface ControlEvents {
  /** The camera is moved. */
  move(move: CameraMove): void;
  /** Playing is started or stopped. */
  toggle(): void;
  /** So many frames on, or back. */
  step(frames: number): void;
}

/**
 * Drag orbits, two fingers pinch and pan, a right or shift drag pans, the wheel zooms, arrow keys orbit, a double click goes back; space
 * plays and pauses, comma and point step. The wheel is left to the page when the page can scroll and the picture is not focused. Returns
 * a function that lets go.
 */
export function controlPicture(picture: HTMLElement, events: ControlEvents): () => void {
  const abort = new AbortController();
  const { signal } = abort;
  const pointers = new Map<number, { x: number; y: number }>();

  picture.addEventListener(
    "pointerdown",
    (event) => {
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      picture.setPointerCapture(event.pointerId);
    },
    { signal },
  );

  picture.addEventListener(
    "pointermove",
    (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const height = Math.max(picture.clientHeight, 1);
      const right = (event.clientX - last.x) / height;
      const down = (event.clientY - last.y) / height;
      const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (other) {
        const before = Math.hypot(last.x - other.x, last.y - other.y);
        const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
        if (before > 0 && after > 0) events.move({ kind: "zoom", factor: before / after });
        events.move({ kind: "pan", right: -right / 2, up: down / 2 });
      } else if (event.shiftKey || event.buttons === 2) {
        events.move({ kind: "pan", right: -right, up: down });
      } else {
        events.move({ kind: "orbit", azimuth: -TURN * right, elevation: TURN * down });
      }
    },
    { signal },
  );

  // `lostpointercapture` follows every end of a touch, a scroll that the browser takes over included.
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
    picture.addEventListener(kind, (event) => pointers.delete(event.pointerId), { signal });
  }

  picture.addEventListener(
    "wheel",
    (event) => {
      if (!wantsWheel(picture, event)) return;
      event.preventDefault();
      const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 * event.deltaY : event.deltaY;
      // A pinch on a touch pad arrives as a wheel with ctrl, in finer steps.
      events.move({ kind: "zoom", factor: Math.exp((event.ctrlKey ? 0.01 : 0.0015) * pixels) });
    },
    { signal, passive: false },
  );

  picture.addEventListener("dblclick", () => events.move({ kind: "reset" }), { signal });
  picture.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });

  picture.addEventListener(
    "keydown",
    (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (obeyKey(event.key, events)) event.preventDefault();
    },
    { signal },
  );

  return () => abort.abort();
}

function wantsWheel(picture: HTMLElement, event: WheelEvent): boolean {
  const page = document.scrollingElement;
  const pageScrolls = page !== null && page.scrollHeight > page.clientHeight;
  return event.ctrlKey || !pageScrolls || picture.matches(":focus");
}

function obeyKey(key: string, events: ControlEvents): boolean {
  switch (key) {
    case " ":
      events.toggle();
      return true;
    case ",":
      events.step(-1);
      return true;
    case ".":
      events.step(1);
      return true;
  }
  const move = keyMove(key);
  if (move) events.move(move);
  return move !== null;
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
    case "=":
      return { kind: "zoom", factor: 0.85 };
    case "-":
      return { kind: "zoom", factor: 1 / 0.85 };
    default:
      return null;
  }
}
