/** Puts a text on the clipboard. */

import { tell } from "./toast.js";

/** Copies `text` and says so; where the browser refuses, the text itself is shown. */
export async function copy(text, done) {
  try {
    await navigator.clipboard.writeText(text);
    tell(done);
  } catch {
    tell(text);
  }
}
