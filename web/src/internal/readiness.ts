import type { CreaseError } from "./crease-error.js";

/** The promise of a first picture, avatar after avatar. */
export class Readiness {
  #promise!: Promise<void>;
  #settle!: { resolve(): void; reject(error: CreaseError): void };
  #settled = false;
  #loaded = false;

  constructor() {
    this.#start();
  }

  /** Resolves at the first picture; rejects with the reason that there is none. */
  get promise(): Promise<void> {
    return this.#promise;
  }

  /** Whether the first picture has been drawn. */
  get loaded(): boolean {
    return this.#loaded;
  }

  /** Begins anew for another avatar. Whoever waits already waits for this one. */
  renew(): void {
    if (this.#settled) this.#start();
  }

  /** The first picture has been drawn. */
  resolve(): void {
    this.#settled = true;
    this.#loaded = true;
    this.#settle.resolve();
  }

  /** There will be none. */
  reject(error: CreaseError): void {
    this.#settled = true;
    this.#settle.reject(error);
  }

  #start(): void {
    this.#settled = false;
    this.#loaded = false;
    this.#promise = new Promise((resolve, reject) => {
      this.#settle = { resolve, reject };
    });
    // Whoever asks for the promise hears of a rejection; nobody has to.
    this.#promise.catch(() => {});
  }
}
