/** Who is on stage, and in which motion; goes back to the last that worked when the next one does not. */

import { tellError } from "./toast.js";

export class Show extends EventTarget {
  /** The element. */
  avatar;
  /** Who is on stage, an entry of the catalogue. */
  person = null;
  /** What they dance, an entry of the catalogue. */
  motion = null;
  #lastPerson = null;
  #lastMotion = null;

  constructor(avatar) {
    super();
    this.avatar = avatar;
    avatar.addEventListener("load", () => {
      this.#lastPerson = this.person;
    });
    avatar.addEventListener("durationchange", () => {
      this.#lastMotion = this.motion;
    });
    avatar.addEventListener("error", ({ error }) => this.#onError(error));
  }

  /** Puts somebody on stage. */
  wear(person) {
    this.person = person;
    this.avatar.alt = `${person.alt}, in motion`;
    this.avatar.poster = person.poster ?? null;
    this.avatar.src = person.src;
    this.dispatchEvent(new Event("change"));
  }

  /** Starts another motion. */
  dance(motion) {
    this.motion = motion;
    this.avatar.fps = motion.fps;
    this.avatar.motion = motion.src;
    this.dispatchEvent(new Event("change"));
  }

  #onError({ url, message }) {
    const failed = [this.motion, this.person].find((entry) => entry && absolute(entry.src) === url);
    // The address of a visitor's own file says nothing; its name does.
    tellError(
      failed?.file ? message.replaceAll(url, failed.file).replaceAll(url.split("/").pop(), failed.file) : message,
    );
    if (failed === this.motion && this.#lastMotion && this.#lastMotion !== failed) this.dance(this.#lastMotion);
    if (failed === this.person && this.#lastPerson && this.#lastPerson !== failed) this.wear(this.#lastPerson);
  }
}

function absolute(address) {
  return new URL(address, document.baseURI).href;
}
