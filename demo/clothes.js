/** Swapping clothes: one avatar wears another's colours, or another's wrinkles. */

import { AVATARS } from "./catalogue.js";

export function setUpClothes(show) {
  document.querySelector("#clothes").hidden = AVATARS.length < 2;
  const selects = ["texture", "detail-from"].map((attribute) => {
    const select = document.getElementById(attribute);
    select.append(...AVATARS.map(({ id, name }) => new Option(name, id)));
    select.addEventListener("change", () => {
      const chosen = AVATARS.find(({ id }) => id === select.value);
      const isOwn = chosen === show.person;
      show.avatar.toggleAttribute(attribute, !isOwn);
      if (!isOwn) show.avatar.setAttribute(attribute, chosen.src);
    });
    return select;
  });
  // Whoever comes on stage wears their own.
  let person = null;
  show.addEventListener("change", () => {
    if (show.person === person) return;
    person = show.person;
    for (const select of selects) {
      show.avatar.removeAttribute(select.id);
      select.value = person?.id ?? "";
    }
  });
}
