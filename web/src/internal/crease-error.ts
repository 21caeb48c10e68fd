import type { ErrorCode, Failure } from "./protocol.js";

/** Why an avatar, a motion or a texture cannot be shown, or a picture or a file not be had. */
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

  /** A failure as it came from the stage. */
  static of({ code, message, url }: Failure): CreaseError {
    return new CreaseError(code, message, url);
  }
}
