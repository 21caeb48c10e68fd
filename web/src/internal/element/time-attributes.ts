import { clamp, finite, numberOf } from "../options.js";
import { SourceAttributes } from "./source-attributes.js";

/** Rates further from zero are taken as this. */
const LARGEST_RATE = 16;
/** Longest crossfade and smoothing, seconds. */
const LONGEST_FADE = 10;

/** How time goes. */
export class TimeAttributes extends SourceAttributes {
  /**
   * Whether playing starts by itself. A person who prefers reduced motion is asked to start it.
   *
   * @attr autoplay
   * @example `<crease-avatar src="avatar.glb" motion="dance.pkl" autoplay></crease-avatar>`
   */
  get autoplay(): boolean {
    return this.hasAttribute("autoplay");
  }
  set autoplay(value: boolean) {
    this.toggleAttribute("autoplay", value);
  }

  /**
   * Whether the motion starts over at its end.
   *
   * @attr loop
   * @example `<crease-avatar src="avatar.glb" motion="dance.pkl" autoplay loop></crease-avatar>`
   */
  get loop(): boolean {
    return this.hasAttribute("loop");
  }
  set loop(value: boolean) {
    this.toggleAttribute("loop", value);
  }

  /**
   * Whether a bar with play, scrub and time lies over the lower edge of the picture. What the page puts into the slot `controls` takes its place.
   *
   * @attr controls
   * @example `<crease-avatar src="avatar.glb" motion="dance.pkl" controls></crease-avatar>`
   */
  get controls(): boolean {
    return this.hasAttribute("controls");
  }
  set controls(value: boolean) {
    this.toggleAttribute("controls", value);
  }

  /**
   * Seconds of motion per second, -16 to 16; negative runs backwards. Fires `ratechange`.
   *
   * @attr playback-rate
   * @example `avatar.playbackRate = 0.5;`
   */
  get playbackRate(): number {
    return clamp(numberOf(this.getAttribute("playback-rate"), 1), -LARGEST_RATE, LARGEST_RATE);
  }
  set playbackRate(value: number) {
    this.reflect("playback-rate", clamp(finite(value, "playbackRate"), -LARGEST_RATE, LARGEST_RATE));
  }

  /**
   * Poses a second, for motion files that hold no rate.
   *
   * @attr fps
   * @example `<crease-avatar src="avatar.glb" motion="aist.pkl" fps="60"></crease-avatar>`
   */
  get fps(): number | null {
    return numberOf(this.getAttribute("fps"), null);
  }
  set fps(value: number | null) {
    this.reflect("fps", value);
  }

  /**
   * Seconds over which one motion fades into the next: within a playlist, over the seam of a loop, and where `motion` changes while it
   * plays. 0.3 unless set, 0 cuts.
   *
   * @attr crossfade
   * @example `<crease-avatar src="avatar.glb" motion="walk.npz dance.npz" crossfade="0.5" autoplay loop></crease-avatar>`
   */
  get crossfade(): number {
    return clamp(numberOf(this.getAttribute("crossfade"), 0.3), 0, LONGEST_FADE);
  }
  set crossfade(value: number) {
    this.reflect("crossfade", clamp(finite(value, "crossfade"), 0, LONGEST_FADE));
  }

  /**
   * Seconds in which a live `pose` covers 63 % of the way to the one that was set last. 0, unless set, jumps.
   *
   * @attr smoothing
   * @example `avatar.smoothing = 0.08; avatar.pose = axisAngles;`
   */
  get smoothing(): number {
    return clamp(numberOf(this.getAttribute("smoothing"), 0), 0, LONGEST_FADE);
  }
  set smoothing(value: number) {
    this.reflect("smoothing", clamp(finite(value, "smoothing"), 0, LONGEST_FADE));
  }
}
