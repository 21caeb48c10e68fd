import { BACKENDS } from "./backend.js";
import type { BackendChoice, QualityChoice, View } from "./protocol.js";

const VIEWS: readonly string[] = ["body", "base", "detailed"] satisfies View[];

const QUALITIES: readonly QualityChoice[] = ["auto", "best", "high", "medium", "low", "lowest"];

/** The view that an attribute names; anything unknown is the detailed one. */
export function viewOf(attribute: string | null): View {
  return attribute !== null && VIEWS.includes(attribute) ? (attribute as View) : "detailed";
}

/** The number that an attribute holds, or `fallback`. */
export function numberOf<T>(attribute: string | null, fallback: T): number | T {
  const number = attribute === null || attribute.trim() === "" ? Number.NaN : Number(attribute);
  return Number.isFinite(number) ? number : fallback;
}

/** The backend that an attribute names; anything unknown is `auto`. */
export function backendOf(attribute: string | null): BackendChoice {
  return BACKENDS.find((backend) => backend === attribute) ?? "auto";
}

/** The quality that an attribute names; anything unknown is `auto`. */
export function qualityOf(attribute: string | null): QualityChoice {
  return QUALITIES.find((quality) => quality === attribute) ?? "auto";
}
