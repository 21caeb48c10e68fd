import type { OrbitWish } from "./protocol.js";

const DEGREE = Math.PI / 180;

const UNITS: Readonly<Record<string, number>> = { rad: 1, deg: DEGREE, m: 1, cm: 0.01, mm: 0.001 };

/** A number with one of `units`, in radians or metres; null for `auto` and for anything else. */
function quantity(text: string | undefined, units: readonly string[]): number | null {
  const match = /^([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)([a-z]+)$/iu.exec(text ?? "");
  const [, number, unit] = match ?? [];
  if (number === undefined || unit === undefined || !units.includes(unit)) return null;
  return Number(number) * (UNITS[unit] ?? 1);
}

const angle = (text: string | undefined): number | null => quantity(text, ["deg", "rad"]);
const metres = (text: string | undefined): number | null => quantity(text, ["m", "cm", "mm"]);

function words(text: string | null): readonly string[] {
  return (text ?? "").trim().split(/\s+/u);
}

/** `camera-orbit`: azimuth, angle from the zenith, and distance, such as `20deg 83deg 4.9m`; each may be `auto`. */
export function orbitOf(text: string | null): OrbitWish {
  const [theta, phi, radius] = words(text);
  const zenithAngle = angle(phi);
  const distance = metres(radius);
  const percent = /^(\d+\.?\d*)%$/u.exec(radius ?? "")?.[1];
  return {
    azimuth: angle(theta),
    elevation: zenithAngle === null ? null : Math.PI / 2 - zenithAngle,
    distance:
      distance !== null ? { metres: distance } : percent !== undefined ? { share: Number(percent) / 100 } : null,
  };
}

/** `camera-target`: three lengths, such as `0m 0.95m 0m`; null for `auto` and for anything else. */
export function targetOf(text: string | null): readonly [number, number, number] | null {
  const [x, y, z] = words(text).map(metres);
  if (x === null || x === undefined || y === null || y === undefined || z === null || z === undefined) return null;
  return [x, y, z];
}

/** `field-of-view`: an angle, such as `28deg`, as radians from 5 to 120 degrees; null for `auto` and for anything else. */
export function fieldOfViewOf(text: string | null): number | null {
  const radians = angle(text?.trim());
  return radians === null ? null : Math.min(Math.max(radians, 5 * DEGREE), 120 * DEGREE);
}

/** `rotation-per-second`: an angle, as radians. */
export function turnOf(text: string | null): number {
  return angle(text?.trim()) ?? 12 * DEGREE;
}

/** Where the camera is about its target. */
export class CameraOrbit {
  /** Radians about the vertical; 0 looks at the figure's front. */
  readonly theta: number;
  /** Radians from the zenith. */
  readonly phi: number;
  /** Metres. */
  readonly radius: number;

  constructor(theta: number, phi: number, radius: number) {
    this.theta = theta;
    this.phi = phi;
    this.radius = radius;
  }

  /** As the attribute `camera-orbit` takes it. */
  toString(): string {
    return `${this.theta.toFixed(4)}rad ${this.phi.toFixed(4)}rad ${this.radius.toFixed(3)}m`;
  }
}

/** What the camera looks at, metres. */
export class CameraTarget {
  readonly x: number;
  readonly y: number;
  readonly z: number;

  constructor(x: number, y: number, z: number) {
    this.x = x;
    this.y = y;
    this.z = z;
  }

  /** As the attribute `camera-target` takes it. */
  toString(): string {
    return `${this.x.toFixed(3)}m ${this.y.toFixed(3)}m ${this.z.toFixed(3)}m`;
  }
}
