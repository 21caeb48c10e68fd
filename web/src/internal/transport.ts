import { make } from "./make.js";

/** What the bar plays: the element, or the part of it that media elements have too. */
export interface Playable extends EventTarget {
  readonly paused: boolean;
  readonly duration: number;
  currentTime: number;
  play(): unknown;
  pause(): void;
}

/** The bar of `controls`: play and pause, a scrub, the time. Shown while there is a motion. */
export class Transport {
  readonly bar = make("div", { class: "transport gone", part: "transport" });
  readonly #player: Playable;
  readonly #play = make("button", { class: "play", part: "play", type: "button" });
  readonly #scrub = make("input", { part: "scrub", type: "range", min: "0", step: "any", "aria-label": "Time" });
  readonly #time = make("span", { class: "time", part: "time", "aria-hidden": "true" });

  constructor(player: Playable) {
    this.#player = player;
    this.bar.append(this.#play, this.#scrub, this.#time);
    this.#play.addEventListener("click", () => {
      if (player.paused) player.play();
      else player.pause();
    });
    this.#scrub.addEventListener("input", (event) => {
      // The page hears of `seeking` and `timeupdate`, as of a video's own bar.
      event.stopPropagation();
      player.currentTime = this.#scrub.valueAsNumber;
      this.#showTime();
    });
    this.#scrub.addEventListener("change", (event) => event.stopPropagation());
    for (const event of ["play", "pause", "ended"]) player.addEventListener(event, () => this.#showPlaying());
    for (const event of ["timeupdate", "seeked"]) player.addEventListener(event, () => this.#showTime());
    player.addEventListener("durationchange", () => this.#showDuration());
    this.#showPlaying();
  }

  #showPlaying(): void {
    const { paused } = this.#player;
    this.#play.classList.toggle("playing", !paused);
    this.#play.setAttribute("aria-label", paused ? "Play" : "Pause");
  }

  #showDuration(): void {
    const { duration } = this.#player;
    this.bar.classList.toggle("gone", !(duration > 0));
    this.#scrub.max = String(duration || 0);
    this.#showTime();
  }

  #showTime(): void {
    const { currentTime, duration } = this.#player;
    if (!this.#scrub.matches(":active")) this.#scrub.valueAsNumber = currentTime;
    this.#scrub.setAttribute("aria-valuetext", `${currentTime.toFixed(1)} of ${duration.toFixed(1)} seconds`);
    this.#time.textContent = `${clock(currentTime)} / ${clock(duration)}`;
  }
}

/** Minutes and seconds. */
function clock(seconds: number): string {
  const whole = Math.floor(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
