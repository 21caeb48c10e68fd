import type { Backend } from "../protocol.js";
import type { Progress } from "../session.js";

/** The element's own events, by name. */
interface OwnEvents {
  progress: CustomEvent<Progress>;
  load: Event;
  /** `error` is a {@link CreaseError}. */
  error: ErrorEvent;
  backendchange: CustomEvent<Backend>;
  play: Event;
  pause: Event;
  timeupdate: Event;
  seeking: Event;
  seeked: Event;
  ended: Event;
  ratechange: Event;
  /** Seconds, and what the motion's reader has to say. */
  durationchange: CustomEvent<{ readonly duration: number; readonly notes: readonly string[] }>;
  "camera-change": Event;
  "poster-dismissed": Event;
}

/** What a listener of `<crease-avatar>` gets, for each name of an event. */
export type CreaseAvatarEventMap = Omit<HTMLElementEventMap, keyof OwnEvents> & OwnEvents;

/** Listeners know what their events carry. */
export interface TypedListeners {
  addEventListener<Name extends keyof CreaseAvatarEventMap>(
    type: Name,
    listener: (event: CreaseAvatarEventMap[Name]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  removeEventListener<Name extends keyof CreaseAvatarEventMap>(
    type: Name,
    listener: (event: CreaseAvatarEventMap[Name]) => unknown,
    options?: boolean | EventListenerOptions,
  ): void;
}
