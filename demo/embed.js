/** The lines that put what is on stage onto another page. */

import { copy } from "./copy.js";

export function setUpEmbed(show) {
  const sheet = document.querySelector("#embed-sheet");
  const code = document.querySelector("#embed-code");
  document.querySelector("#embed").addEventListener("click", () => {
    code.textContent = snippet(show);
    sheet.showModal();
  });
  document.querySelector("#embed-copy").addEventListener("click", () => {
    sheet.close();
    copy(code.textContent, "Snippet copied");
  });
}

function snippet({ avatar, person, motion }) {
  const attributes = {
    src: address(person),
    motion: address(motion),
    fps: motion.fps,
    ...(avatar.detail === 1 ? {} : { detail: avatar.detail }),
    ...(avatar.view === "detailed" ? {} : { view: avatar.view }),
    alt: avatar.alt,
  };
  const lines = Object.entries(attributes).map(([name, value]) => `  ${name}="${quoted(String(value))}"`);
  return `<script type="module" src="/crease-avatar/crease-avatar.js"></script>
<crease-avatar
${lines.join("\n")}
  autoplay
  loop
  camera-controls
></crease-avatar>`;
}

/** A visitor's own file has a name, but no address yet. */
function address({ src, file }) {
  return file ?? new URL(src, document.baseURI).href;
}

function quoted(text) {
  return text.replaceAll("&", "&amp;").replaceAll('"', "&quot;");
}
