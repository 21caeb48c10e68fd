import type { ClockWish } from "./protocol.js";

/** Milliseconds between two `timeupdate` events. */
const TIME_UPDATE_INTERVAL = 250;

/** What tells how time goes on: a drawn frame. */
interface Moment {
  readonly order: number;
  readonly currentTime: number;
  readonly ended: boolean;
}

/** Whom a media state serves. */
export interface MediaHost {
  /** Fires an event of this name. */
  tell(event: string): void;
  /** Passes a wish on to whatever plays. */
  wish(wish: ClockWish): void;
}

/** Time as the page sees it, with the meaning that HTML's media elements give it. What plays is elsewhere and answers late. */
export class MediaState {
  readonly #host: MediaHost;
  #order = 0;
  #playing = false;
  #currentTime = 0;
  #duration = Number.NaN;
  #ended = false;
  #seeking = false;
  #lastUpdate = Number.NEGATIVE_INFINITY;

  constructor(host: MediaHost) {
    this.#host = host;
  }

  get paused(): boolean {
    return !this.#playing;
  }

  get ended(): boolean {
    return this.#ended;
  }

  get seeking(): boolean {
    return this.#seeking;
  }

  get currentTime(): number {
    return this.#currentTime;
  }

  get duration(): number {
    return this.#duration;
  }

  /** What a stage that opens now is told. */
  get wish(): ClockWish {
    return { order: this.#order, playing: this.#playing, seconds: this.#currentTime > 0 ? this.#currentTime : null };
  }

  play(): void {
    if (this.#playing) return;
    this.#playing = true;
    this.#ended = false;
    this.#send(null);
    this.#host.tell("play");
  }

  pause(): void {
    if (!this.#playing) return;
    this.#playing = false;
    this.#send(null);
    this.#update();
    this.#host.tell("pause");
  }

  /** Goes to `seconds`, clamped to the motion. Before there is one, that is where it will start. */
  seek(seconds: number): void {
    this.#currentTime = this.#clamped(seconds);
    this.#ended = false;
    this.#send(this.#currentTime);
    if (Number.isNaN(this.#duration)) return;
    this.#seeking = true;
    this.#host.tell("seeking");
  }

  /** Another motion is being loaded: it starts at its beginning. */
  restart(): void {
    this.#currentTime = 0;
    this.#ended = false;
  }

  /** Another avatar is being loaded: nothing is known of its motion. */
  forget(): void {
    this.#duration = Number.NaN;
    this.#seeking = false;
    this.#ended = false;
  }

  /** A motion is there. */
  loaded(duration: number): void {
    this.#duration = duration;
    this.#currentTime = this.#clamped(this.#currentTime);
  }

  /** Stops at `seconds` for a frame that is shown exactly. Returns the order that the frame will obey. */
  hold(seconds: number): number {
    const wasPlaying = this.#playing;
    this.#playing = false;
    this.#order += 1;
    this.#currentTime = this.#clamped(seconds);
    this.#ended = false;
    if (wasPlaying) this.#host.tell("pause");
    this.#seeking = true;
    this.#host.tell("seeking");
    return this.#order;
  }

  /** A picture of this moment is on the screen, or would be. Pictures from before the latest wish say nothing. */
  hear(moment: Moment, now: number): void {
    if (moment.order < this.#order) return;
    this.#currentTime = moment.currentTime;
    this.#ended = moment.ended;
    if (this.#seeking) {
      this.#seeking = false;
      this.#update(now);
      this.#host.tell("seeked");
    }
    if (moment.ended && this.#playing) {
      this.#playing = false;
      this.#update(now);
      this.#host.tell("pause");
      this.#host.tell("ended");
    } else if (this.#playing && now - this.#lastUpdate >= TIME_UPDATE_INTERVAL) {
      this.#update(now);
    }
  }

  #update(now = this.#lastUpdate): void {
    this.#lastUpdate = now;
    this.#host.tell("timeupdate");
  }

  #send(seconds: number | null): void {
    this.#order += 1;
    this.#host.wish({ order: this.#order, playing: this.#playing, seconds });
  }

  #clamped(seconds: number): number {
    const least = Math.max(seconds, 0);
    return Number.isNaN(this.#duration) ? least : Math.min(least, this.#duration);
  }
}
