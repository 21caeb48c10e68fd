/** Views on the wasm module's memory, made again only when that has grown. */
export class MemoryView {
  readonly #memory: WebAssembly.Memory;
  #words: Uint32Array;

  constructor(memory: WebAssembly.Memory) {
    this.#memory = memory;
    this.#words = new Uint32Array(memory.buffer);
  }

  /** All of the memory in words of 32 bits. An address divided by four is an index. */
  get words(): Uint32Array {
    if (this.#words.buffer !== this.#memory.buffer) this.#words = new Uint32Array(this.#memory.buffer);
    return this.#words;
  }
}
