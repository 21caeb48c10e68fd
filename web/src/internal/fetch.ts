import { StageError } from "./errors.js";

/** Bytes that have come, and bytes that will have come, where the server says so. */
export type OnBytes = (loaded: number, total: number | null) => void;

/** The bytes at `url`; tells of every piece that arrives. */
export async function fetchBytes(url: string, onBytes: OnBytes = () => {}): Promise<Uint8Array> {
  let response: Response;
  try {
    response = await fetch(url);
  } catch (thrown) {
    throw new StageError("network", `${url}: ${String(thrown)}`, url);
  }
  if (!response.ok) {
    throw new StageError("network", `${url}: expected a file, found status ${response.status}`, url);
  }
  try {
    return await collect(response, onBytes);
  } catch (thrown) {
    throw new StageError("network", `${url}: the download broke off: ${String(thrown)}`, url);
  }
}

/** The body of `response` as it arrives. A compressed body is longer than its header says; then the length is unknown. */
export async function collect(response: Response, onBytes: OnBytes): Promise<Uint8Array> {
  const encoded = (response.headers.get("content-encoding") ?? "identity") !== "identity";
  const length = Number(response.headers.get("content-length") ?? "");
  const total = !encoded && length > 0 ? length : null;
  if (!response.body) return new Uint8Array(await response.arrayBuffer());
  let bytes = new Uint8Array(total ?? 1 << 16);
  let loaded = 0;
  const reader = response.body.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    if (loaded + value.length > bytes.length) bytes = grown(bytes, loaded + value.length);
    bytes.set(value, loaded);
    loaded += value.length;
    onBytes(loaded, total);
  }
  return bytes.subarray(0, loaded);
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
