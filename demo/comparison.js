/** The wipe: on its left a second avatar without wrinkles, in the same pose, seen from the same place. */

const ATTRIBUTES = [
  "src",
  "motion",
  "fps",
  "crossfade",
  "texture",
  "theme",
  "environment",
  "follow",
  "quality",
  "backend",
];

export function setUpComparison(show) {
  const button = document.querySelector("#compare");
  const wipe = document.querySelector("#wipe");
  let comparison = null;
  button.addEventListener("click", () => {
    comparison?.end();
    comparison = comparison ? null : new Comparison(show.avatar);
    button.ariaPressed = String(comparison !== null);
    wipe.hidden = comparison === null;
    if (comparison) comparison.wipe = wipe.valueAsNumber;
  });
  wipe.addEventListener("input", () => {
    if (comparison) comparison.wipe = wipe.valueAsNumber;
  });
}

class Comparison {
  #avatar;
  #before = document.createElement("crease-avatar");
  #observer;
  #request = 0;

  constructor(avatar) {
    this.#avatar = avatar;
    this.#before.className = "before";
    this.#before.inert = true;
    this.#before.view = "base";
    for (const name of ATTRIBUTES) this.#copy(name);
    this.#observer = new MutationObserver((changes) => {
      for (const { attributeName } of changes) this.#copy(attributeName);
    });
    this.#observer.observe(avatar, { attributeFilter: ATTRIBUTES });
    avatar.after(this.#before);
    this.#keepUp();
  }

  /** How much of the stage, from the left, is without wrinkles. */
  set wipe(share) {
    this.#before.style.setProperty("--wipe", share);
  }

  end() {
    this.#observer.disconnect();
    cancelAnimationFrame(this.#request);
    this.#before.remove();
  }

  #copy(name) {
    const value = this.#avatar.getAttribute(name);
    if (value === null) this.#before.removeAttribute(name);
    else this.#before.setAttribute(name, value);
  }

  /** The second avatar has no time and no camera of its own. */
  #keepUp = () => {
    const [avatar, before] = [this.#avatar, this.#before];
    if (avatar.loaded) {
      if (before.currentTime !== avatar.currentTime) before.currentTime = avatar.currentTime;
      const orbit = avatar.getCameraOrbit().toString();
      const target = avatar.getCameraTarget().toString();
      if (before.cameraOrbit !== orbit || before.cameraTarget !== target) {
        before.cameraOrbit = orbit;
        before.cameraTarget = target;
        before.fieldOfView = `${avatar.getFieldOfView()}deg`;
        before.jumpCameraToGoal();
      }
    }
    this.#request = requestAnimationFrame(this.#keepUp);
  };
}
