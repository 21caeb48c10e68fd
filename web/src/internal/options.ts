import type { View } from "./protocol.js";

const VIEWS: readonly string[] = ["body", "base", "detailed"] satisfies View[];

/** The view that an attribute names; anything unknown is the detailed one. */
export function viewOf(attribute: string | null): View {
  return attribute !== null && VIEWS.includes(attribute) ? (attribute as View) : "detailed";
}

/** The number that an attribute holds, or `fallback`. */
export function numberOf<T>(attribute: string | null, fallback: T): number | T {
  const number = attribute === null || attribute.trim() === "" ? Number.NaN : Number(attribute);
  return Number.isFinite(number) ? number : fallback;
}
