import { failureOf, isPanic, StageError } from "./errors.js";
import type { Backend, BackendChoice } from "./protocol.js";

/** All backends, the fastest first: what computes and what draws. */
export const BACKENDS: readonly Backend[] = ["webgpu", "webgpu+cpu", "webgl2+cpu"];

/** The backends to try for a choice, in order: the chosen one, then the slower ones. */
export function candidates(choice: BackendChoice): readonly Backend[] {
  return choice === "auto" ? BACKENDS : BACKENDS.slice(BACKENDS.indexOf(choice));
}

/** What was opened, and as which backend. */
export interface Opened<T> {
  readonly backend: Backend;
  readonly value: T;
}

/** Opens the first of `backends` that works; `tell` hears why others do not. Throws `unsupported` with all reasons if none does. */
export async function openFirst<T>(
  backends: readonly Backend[],
  open: (backend: Backend) => Promise<T>,
  tell: (message: string) => void,
): Promise<Opened<T>> {
  const reasons: string[] = [];
  for (const [index, backend] of backends.entries()) {
    try {
      return { backend, value: await open(backend) };
    } catch (thrown) {
      if (isPanic(thrown)) throw thrown;
      reasons.push(reasonAgainst(backend, thrown));
      const next = backends[index + 1];
      if (next) tell(reasonForNext(backend, thrown, next));
    }
  }
  throw new StageError("unsupported", `Nothing here can draw the figure. ${reasons.join(". ")}.`);
}

function reasonAgainst(backend: Backend, thrown: unknown): string {
  return `${backend}: ${failureOf(thrown, null).message}`;
}

/** What people are told where `next` stands in for `backend`. */
export function reasonForNext(backend: Backend, thrown: unknown, next: Backend): string {
  return `crease-avatar: ${reasonAgainst(backend, thrown)}. Using ${next} instead.`;
}

/** A teller that says the same thing only once. */
export function once(tell: (message: string) => void): (message: string) => void {
  const told = new Set<string>();
  return (message) => {
    if (told.has(message)) return;
    told.add(message);
    tell(message);
  };
}
