/** Who is on stage. */

import { AVATARS } from "./catalogue.js";
import { fillChoices } from "./choices.js";

export function setUpPersons(show) {
  const place = document.querySelector("#persons");
  place.closest("fieldset").hidden = AVATARS.length < 2;
  const options = AVATARS.map(({ id, name }) => ({ value: id, name }));
  const choose = (id) => show.wear(AVATARS.find((avatar) => avatar.id === id));
  const mark = fillChoices(place, "person", options, choose);
  show.addEventListener("change", () => mark(show.person?.id));
}
