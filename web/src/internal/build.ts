import { BUILD } from "../../pkg/build.js";
import { StageError } from "./errors.js";

/** The error of the file at `url`, which says that it is of build `found`; null where that is this script's build, too. */
export function errorOfBuild(found: string | undefined, url: string): StageError | null {
  if (found === BUILD) return null;
  const reason = `${url}: expected a file of build ${BUILD}, found ${found ?? "one without a name"}`;
  return new StageError("version", `${reason}. Reload the page, or clear its cache and its service worker.`, url);
}
