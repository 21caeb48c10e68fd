/** How a stage's settings follow from the element's attributes. */

import { fieldOfViewOf, orbitOf, targetOf, turnOf } from "../camera-place.js";
import { colourOf } from "../colour.js";
import { absolute, addressesOf } from "../options.js";
import type { Settings, Theme } from "../protocol.js";
import type { LookAttributes } from "./look-attributes.js";

export type SettingName = keyof Settings;

/** Attributes that a stage is told of, and the setting that follows from each. */
export const SETTINGS_OF_ATTRIBUTES: Readonly<Record<string, SettingName>> = {
  motion: "motions",
  fps: "motions",
  crossfade: "crossfade",
  texture: "texture",
  "detail-from": "detailFrom",
  "max-bytes": "maxBytes",
  loop: "loop",
  "playback-rate": "playbackRate",
  smoothing: "smoothing",
  view: "view",
  detail: "detail",
  liveliness: "liveliness",
  theme: "theme",
  background: "background",
  environment: "environment",
  shadow: "shadow",
  follow: "follow",
  "camera-orbit": "orbit",
  "camera-target": "target",
  "field-of-view": "fieldOfView",
  "auto-rotate": "turn",
  "auto-rotate-delay": "turn",
  "rotation-per-second": "turn",
  backend: "backend",
  quality: "quality",
};

/** All settings, as the attributes say now. */
export function settingsOf(element: LookAttributes): Settings {
  const framesPerSecond = element.fps;
  const turns = element.autoRotate && !prefersReducedMotion();
  return {
    view: element.view,
    detail: element.detail,
    liveliness: element.liveliness,
    theme: themeOf(element),
    background: colourOf(element.background),
    environment: element.environment,
    shadow: element.shadow,
    follow: element.follow,
    orbit: orbitOf(element.cameraOrbit),
    target: targetOf(element.cameraTarget),
    fieldOfView: fieldOfViewOf(element.fieldOfView),
    turn: {
      radiansPerSecond: turns ? turnOf(element.rotationPerSecond) : 0,
      restSeconds: element.autoRotateDelay / 1000,
    },
    loop: element.loop,
    playbackRate: element.playbackRate,
    motions: addressesOf(element.motion).map((address) => ({ url: absolute(address), framesPerSecond })),
    crossfade: element.crossfade,
    texture: element.texture ? absolute(element.texture) : null,
    detailFrom: element.detailFrom ? absolute(element.detailFrom) : null,
    smoothing: element.smoothing,
    backend: element.backend,
    quality: element.quality,
    maxBytes: element.maxBytes,
  };
}

/** Whether the viewer has asked pages to keep still. */
export function prefersReducedMotion(): boolean {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}

function themeOf({ theme }: LookAttributes): Theme {
  if (theme !== "auto") return theme;
  return matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
}
