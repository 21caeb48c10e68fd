/** A load of which only the latest counts: a new one cancels the one before. */
export class LatestLoad {
  #controller: AbortController | null = null;

  /** Cancels the load before this one, and returns the signal of this one. */
  begin(): AbortSignal {
    this.cancel();
    this.#controller = new AbortController();
    return this.#controller.signal;
  }

  /** Cancels the load, if there is one. */
  cancel(): void {
    this.#controller?.abort();
    this.#controller = null;
  }
}
