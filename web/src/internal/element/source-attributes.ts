import { numberOf } from "../options.js";
import { ReflectingElement } from "./reflecting.js";

/** What is shown, and when it is fetched and revealed. */
export class SourceAttributes extends ReflectingElement {
  /**
   * Address of the avatar, a GLB with crease's extension. Another address cancels the load of the one before.
   *
   * @attr src
   * @example `<crease-avatar src="avatar.glb"></crease-avatar>`
   */
  get src(): string | null {
    return this.getAttribute("src");
  }
  set src(value: string | null) {
    this.reflect("src", value);
  }

  /**
   * Address of the motion, or of several, separated by spaces: a playlist, played as one motion. AIST++ `.pkl`, AMASS or SMPL-X-style
   * `.npz`. Without one the avatar stands.
   *
   * @attr motion
   * @example `<crease-avatar src="avatar.glb" motion="walk.npz dance.pkl" fps="60" autoplay loop></crease-avatar>`
   */
  get motion(): string | null {
    return this.getAttribute("motion");
  }
  set motion(value: string | null) {
    this.reflect("motion", value);
  }

  /**
   * Address of a picture that replaces the avatar's texture, or of another avatar whose texture it takes: both are laid out alike where
   * the bodies are the same.
   *
   * @attr texture
   * @example `<crease-avatar src="avatar.glb" texture="other.glb"></crease-avatar>`
   */
  get texture(): string | null {
    return this.getAttribute("texture");
  }
  set texture(value: string | null) {
    this.reflect("texture", value);
  }

  /**
   * Address of another avatar whose wrinkles this one wears, computed every frame on this one's base. Both must have the same body.
   *
   * @attr detail-from
   * @example `<crease-avatar src="avatar.glb" detail-from="other.glb"></crease-avatar>`
   */
  get detailFrom(): string | null {
    return this.getAttribute("detail-from");
  }
  set detailFrom(value: string | null) {
    this.reflect("detail-from", value);
  }

  /**
   * Address of a picture that is shown until the avatar is. The slot `poster` takes any other content.
   *
   * @attr poster
   * @example `<crease-avatar src="avatar.glb" poster="avatar.webp"></crease-avatar>`
   */
  get poster(): string | null {
    return this.getAttribute("poster");
  }
  set poster(value: string | null) {
    this.reflect("poster", value);
  }

  /**
   * What the picture shows, for people who do not see it.
   *
   * @attr alt
   * @example `<crease-avatar src="avatar.glb" alt="A woman in a red coat, dancing"></crease-avatar>`
   */
  get alt(): string | null {
    return this.getAttribute("alt");
  }
  set alt(value: string | null) {
    this.reflect("alt", value);
  }

  /**
   * `eager` fetches at once; `lazy` fetches nothing until the element is near the part of the page that can be seen.
   *
   * @attr loading
   * @example `<crease-avatar src="avatar.glb" loading="lazy"></crease-avatar>`
   */
  get loading(): "eager" | "lazy" {
    return this.getAttribute("loading") === "lazy" ? "lazy" : "eager";
  }
  set loading(value: "eager" | "lazy") {
    this.reflect("loading", value);
  }

  /**
   * When the poster goes: `auto`, with the first picture; `interaction`, when it is clicked or a key is pressed on it; `manual`, when
   * `dismissPoster()` is called.
   *
   * @attr reveal
   * @example `<crease-avatar src="avatar.glb" poster="avatar.webp" reveal="interaction"></crease-avatar>`
   */
  get reveal(): "auto" | "interaction" | "manual" {
    const reveal = this.getAttribute("reveal");
    return reveal === "interaction" || reveal === "manual" ? reveal : "auto";
  }
  set reveal(value: "auto" | "interaction" | "manual") {
    this.reflect("reveal", value);
  }

  /**
   * Largest file that is accepted, bytes; a larger one is the error `too-large`. No limit without it.
   *
   * @attr max-bytes
   * @example `<crease-avatar src="avatar.glb" max-bytes="20000000"></crease-avatar>`
   */
  get maxBytes(): number | null {
    const bytes = numberOf(this.getAttribute("max-bytes"), null);
    return bytes !== null && bytes >= 0 ? bytes : null;
  }
  set maxBytes(value: number | null) {
    this.reflect("max-bytes", value);
  }
}
