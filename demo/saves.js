/** Taking it home: the present picture, a film, the present mesh. */

import { tell, tellError } from "./toast.js";

/** The longest film, seconds. */
const LONGEST = 8;
const FRAMES_PER_SECOND = 30;

export function setUpSaves(show) {
  const { avatar } = show;
  const film = () => {
    const seconds = Math.min(avatar.duration || 1, LONGEST);
    tell(`Filming ${seconds.toFixed(0)} seconds, frame by frame …`);
    return avatar.record({ seconds, fps: FRAMES_PER_SECOND });
  };
  wire("picture", "png", show, () => avatar.toBlob());
  wire("film", "webm", show, film);
  wire("mesh", "glb", show, () => avatar.exportMesh({ format: "glb" }));
}

function wire(id, ending, show, make) {
  const button = document.getElementById(id);
  button.addEventListener("click", async () => {
    button.disabled = true;
    try {
      download(await make(), `${show.person.id ?? "avatar"}-${show.motion.id ?? "motion"}.${ending}`);
    } catch (error) {
      tellError(error.message);
    } finally {
      button.disabled = false;
    }
  });
}

function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The browser has begun to read it by then.
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  tell(`Saved ${name}`);
}
