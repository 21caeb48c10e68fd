import type { ErrorCode } from "./protocol.js";

/** Why an avatar or a motion cannot be shown. */
export class CreaseError extends Error {
  override readonly name = "CreaseError";
  /** For programs. */
  readonly code: ErrorCode;
  /** The file that it is about. */
  readonly url: string | null;

  constructor(code: ErrorCode, message: string, url: string | null) {
    super(message);
    this.code = code;
    this.url = url;
  }
}
