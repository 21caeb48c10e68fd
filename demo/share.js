/** A link to just this picture: who, which motion, when, from where. */

import { copy } from "./copy.js";
import { tellError } from "./toast.js";

/** Attributes that go into the link where they are set. */
const KEPT = ["view", "detail", "environment", "texture", "detail-from"];

export function setUpShare(show) {
  document.querySelector("#share").addEventListener("click", () => {
    if (show.person.file || show.motion.file) tellError("A file of your own cannot be put into a link");
    else copy(linkTo(show), "Link copied");
  });
}

function linkTo({ avatar, person, motion }) {
  const url = new URL(location.pathname, location.href);
  const put = (name, value) => url.searchParams.set(name, value);
  put("avatar", person.id);
  put("motion", motion.id);
  put("time", avatar.currentTime.toFixed(3));
  put("orbit", avatar.getCameraOrbit().toString());
  put("target", avatar.getCameraTarget().toString());
  if (avatar.paused) put("paused", "");
  for (const name of KEPT) {
    if (avatar.hasAttribute(name)) put(name, avatar.getAttribute(name));
  }
  return url.href;
}

/** Puts the element into the state that a link asks for. */
export function applyLink(avatar, link) {
  for (const name of KEPT) {
    if (link.has(name)) avatar.setAttribute(name, link.get(name));
  }
  if (link.has("orbit")) avatar.cameraOrbit = link.get("orbit");
  if (link.has("target")) avatar.cameraTarget = link.get("target");
  if (link.has("paused")) avatar.pause();
  const time = Number(link.get("time") ?? Number.NaN);
  if (time >= 0) avatar.currentTime = time;
}
