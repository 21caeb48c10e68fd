/** A visitor's own files: dropped anywhere on the page, or chosen. */

import { tellError } from "./toast.js";

const MOTION_ENDINGS = ["pkl", "npz"];

export function setUpDrop(show) {
  const veil = document.querySelector("#veil");
  const chooser = document.querySelector("#file");
  const carriesFiles = (event) => event.dataTransfer?.types.includes("Files");

  addEventListener("dragover", (event) => {
    if (!carriesFiles(event)) return;
    event.preventDefault();
    veil.hidden = false;
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) veil.hidden = true;
  });
  addEventListener("drop", (event) => {
    if (!carriesFiles(event)) return;
    event.preventDefault();
    veil.hidden = true;
    for (const file of event.dataTransfer.files) take(show, file);
  });
  document.querySelector("#open").addEventListener("click", () => chooser.click());
  chooser.addEventListener("change", () => {
    for (const file of chooser.files) take(show, file);
    chooser.value = "";
  });
}

/** Plays `file`, or says why it does not. */
function take(show, file) {
  const ending = file.name.split(".").pop().toLowerCase();
  const entry = { id: null, name: file.name, file: file.name, src: URL.createObjectURL(file) };
  if (ending === "glb") {
    show.wear({ ...entry, alt: "A visitor's own avatar" });
  } else if (MOTION_ENDINGS.includes(ending)) {
    show.dance({ ...entry, fps: show.motion?.fps ?? 60 });
  } else {
    tellError(`${file.name}: expected an avatar (.glb) or a motion (.pkl, .npz), found .${ending}`);
  }
}
