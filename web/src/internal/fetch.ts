import { StageError } from "./errors.js";

/** Bytes that have come, and bytes that will have come, where the server says so. */
export type OnBytes = (loaded: number, total: number | null) => void;

/** Choices of a download. */
export interface FetchOptions {
  /** Ends it. */
  readonly signal?: AbortSignal;
  /** Largest file that is accepted; null is any. */
  readonly maxBytes?: number | null;
  /** Hears of every piece that arrives. */
  readonly onBytes?: OnBytes;
}

/** The bytes at `url`. */
export function fetchBytes(url: string, options: FetchOptions = {}): Promise<Uint8Array> {
  const { signal, maxBytes = null, onBytes = () => {} } = options;
  return fetchFile(url, signal ? { signal } : {}, (response) => collect(response, onBytes, maxBytes));
}

/** What `read` makes of the file at `url`. */
export async function fetchFile<T>(
  url: string,
  options: RequestInit,
  read: (response: Response) => Promise<T>,
): Promise<T> {
  let response: Response;
  try {
    response = await fetch(url, options);
  } catch (thrown) {
    throw new StageError("network", `${url}: expected an answer that this page may read, found ${String(thrown)}`, url);
  }
  try {
    if (!response.ok) throw new StageError("http", `${url}: expected a file, found status ${response.status}`, url);
    const type = response.headers.get("content-type") ?? "";
    // A server that answers every address with its start page says 200.
    if (/^text\/html\b/u.test(type)) throw new StageError("type", `${url}: expected a file, found a web page`, url);
    return await read(response);
  } catch (thrown) {
    void response.body?.cancel().catch(() => {});
    if (thrown instanceof StageError) throw new StageError(thrown.code, thrown.message, url);
    throw new StageError("network", `${url}: expected the whole file, found ${String(thrown)} in mid-download`, url);
  }
}

/**
 * The body of `response` as it arrives, of `maxBytes` at most. A compressed body is longer than its header says; then the length is
 * unknown.
 */
export async function collect(
  response: Response,
  onBytes: OnBytes,
  maxBytes: number | null = null,
): Promise<Uint8Array> {
  const encoded = (response.headers.get("content-encoding") ?? "identity") !== "identity";
  const length = Number(response.headers.get("content-length") ?? "");
  const total = !encoded && length > 0 ? length : null;
  refuseMore(total ?? 0, maxBytes, response.url);
  if (!response.body) return new Uint8Array(await response.arrayBuffer());
  let bytes = new Uint8Array(total ?? 1 << 16);
  let loaded = 0;
  const reader = response.body.getReader();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      refuseMore(loaded + value.length, maxBytes, response.url);
      if (loaded + value.length > bytes.length) bytes = grown(bytes, loaded + value.length);
      bytes.set(value, loaded);
      loaded += value.length;
      onBytes(loaded, total);
    }
  } finally {
    reader.releaseLock();
  }
  return bytes.subarray(0, loaded);
}

function refuseMore(bytes: number, maxBytes: number | null, url: string): void {
  if (maxBytes === null || bytes <= maxBytes) return;
  throw new StageError("too-large", `${url}: expected ${maxBytes} bytes at most (max-bytes), found ${bytes} or more`);
}

function grown(bytes: Uint8Array, least: number): Uint8Array<ArrayBuffer> {
  const larger = new Uint8Array(Math.max(least, 2 * bytes.length));
  larger.set(bytes);
  return larger;
}

/** The last part of a path, for messages. */
export function fileName(url: string): string {
  return url.split(/[?#]/u)[0]?.split("/").pop() || url;
}
