import { BACKENDS } from "./backend.js";
import type { BackendChoice, Environment, Follow, QualityChoice, View } from "./protocol.js";

const VIEWS: readonly View[] = ["detailed", "base", "body", "wireframe", "normals", "laplacian"];
const QUALITIES: readonly QualityChoice[] = ["auto", "best", "high", "medium", "low", "lowest"];
const ENVIRONMENTS: readonly Environment[] = ["studio", "daylight", "sunset", "night"];

/** The one of `choices` that an attribute names; anything unknown is the first. */
function oneOf<T extends string>(attribute: string | null, choices: readonly T[]): T {
  return choices.find((choice) => choice === attribute) ?? (choices[0] as T);
}

/** The view that an attribute names; anything unknown is the detailed one. */
export function viewOf(attribute: string | null): View {
  return oneOf(attribute, VIEWS);
}

/** The number that an attribute holds, or `fallback`. */
export function numberOf<T>(attribute: string | null, fallback: T): number | T {
  const number = attribute === null || attribute.trim() === "" ? Number.NaN : Number(attribute);
  return Number.isFinite(number) ? number : fallback;
}

/** `number`, or the end of the range that is nearer. */
export function clamp(number: number, least: number, most: number): number {
  return Math.min(Math.max(number, least), most);
}

/** `value`, if it is a finite number; else a TypeError that names `what`, as the setters of media elements throw. */
export function finite(value: number, what: string): number {
  const number = Number(value);
  if (!Number.isFinite(number)) throw new TypeError(`${what}: expected a finite number, found ${value}`);
  return number;
}

/** The backend that an attribute names; anything unknown is `auto`. */
export function backendOf(attribute: string | null): BackendChoice {
  return BACKENDS.find((backend) => backend === attribute) ?? "auto";
}

/** The quality that an attribute names; anything unknown is `auto`. */
export function qualityOf(attribute: string | null): QualityChoice {
  return oneOf(attribute, QUALITIES);
}

/** The environment that an attribute names; anything unknown is the studio. */
export function environmentOf(attribute: string | null): Environment {
  return oneOf(attribute, ENVIRONMENTS);
}

/** How the camera follows: `follow` alone keeps the root in the middle, `follow="none"` stays, no attribute comes along softly. */
export function followOf(attribute: string | null): Follow {
  if (attribute === "" || attribute === "root") return "root";
  return attribute === "none" ? "none" : "soft";
}

/** The addresses in a list separated by white space. */
export function addressesOf(attribute: string | null): readonly string[] {
  return (attribute ?? "").split(/\s+/u).filter((address) => address !== "");
}

/** An address in full, relative ones taken from the page's. */
export function absolute(address: string): string {
  return new URL(address, document.baseURI).href;
}
