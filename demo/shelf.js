/** The shelf of motions: a picture each. */

import { MOTIONS } from "./catalogue.js";

export function setUpShelf(show) {
  const shelf = document.querySelector("#motions");
  const cards = MOTIONS.map((motion) => card(motion, () => show.dance(motion)));
  shelf.append(...cards.map(({ item }) => item));
  show.addEventListener("change", () => {
    for (const { motion, button } of cards) button.ariaPressed = String(motion.id === show.motion?.id);
  });
}

function card(motion, onClick) {
  const item = document.createElement("li");
  const button = document.createElement("button");
  button.type = "button";
  button.className = "card";
  const picture = document.createElement("img");
  picture.src = `demo/pictures/${motion.id}.webp`;
  picture.alt = "";
  picture.width = 192;
  picture.height = 160;
  const name = document.createElement("span");
  name.textContent = motion.name;
  button.append(picture, name);
  button.addEventListener("click", onClick);
  item.append(button);
  return { motion, item, button };
}
