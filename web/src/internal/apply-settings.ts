import type { Viewer } from "../../pkg/crease.js";
import type { CameraMove, CameraPlace, Settings } from "./protocol.js";

/** Tells `viewer` of those settings that need no load. */
export function applySettings(viewer: Viewer, settings: Partial<Settings>): void {
  const { background, orbit, turn } = settings;
  if (settings.view !== undefined) viewer.setView(settings.view);
  if (settings.detail !== undefined) viewer.setDetail(settings.detail);
  if (settings.liveliness !== undefined) viewer.setLiveliness(settings.liveliness);
  if (settings.theme !== undefined) viewer.setTheme(settings.theme);
  if (background !== undefined) viewer.setBackground(background ? new Float32Array(background) : undefined);
  if (settings.environment !== undefined) viewer.setEnvironment(settings.environment);
  if (settings.shadow !== undefined) viewer.setShadow(settings.shadow);
  if (settings.quality !== undefined) viewer.setQuality(settings.quality);
  if (settings.loop !== undefined) viewer.setLoop(settings.loop);
  if (settings.playbackRate !== undefined) viewer.setPlaybackRate(settings.playbackRate);
  if (settings.smoothing !== undefined) viewer.setSmoothing(settings.smoothing);
  if (settings.follow !== undefined) viewer.setFollow(settings.follow);
  if (orbit !== undefined) {
    const { azimuth, elevation, distance } = orbit;
    const metres = distance && "metres" in distance ? distance.metres : undefined;
    const share = distance && "share" in distance ? distance.share : 1;
    viewer.setOrbit(azimuth ?? undefined, elevation ?? undefined, metres, share);
  }
  if (settings.target !== undefined) viewer.setTarget(settings.target ? new Float32Array(settings.target) : undefined);
  if (settings.fieldOfView !== undefined) viewer.setFieldOfView(settings.fieldOfView ?? undefined);
  if (turn !== undefined) viewer.setTurn(turn.radiansPerSecond, turn.restSeconds);
}

/** Moves the camera of `viewer`. */
export function moveCamera(viewer: Viewer, move: CameraMove): void {
  switch (move.kind) {
    case "orbit":
      viewer.orbit(move.azimuth, move.elevation);
      break;
    case "pan":
      viewer.pan(move.right, move.up);
      break;
    case "zoom":
      viewer.zoom(move.factor);
      break;
    case "reset":
      viewer.resetCamera();
      break;
    case "jump":
      viewer.jumpCamera();
      break;
  }
}

/** Where the camera of `viewer` is. */
export function cameraPlace(viewer: Viewer): CameraPlace {
  const [azimuth = 0, elevation = 0, distance = 0, x = 0, y = 0, z = 0, fieldOfView = 0] = viewer.cameraPlace;
  return { azimuth, elevation, distance, target: [x, y, z], fieldOfView };
}
