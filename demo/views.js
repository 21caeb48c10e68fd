/** Which surface is drawn. */

import { fillChoices } from "./choices.js";

const VIEWS = [
  { value: "detailed", name: "Detailed" },
  { value: "base", name: "Base" },
  { value: "body", name: "Body" },
  { value: "wireframe", name: "Wireframe" },
  { value: "normals", name: "Normals" },
  { value: "laplacian", name: "Laplacian" },
];

export function setUpViews(avatar) {
  const mark = fillChoices(document.querySelector("#views"), "view", VIEWS, (view) => {
    avatar.view = view;
  });
  const show = () => mark(avatar.view);
  new MutationObserver(show).observe(avatar, { attributeFilter: ["view"] });
  show();
}
