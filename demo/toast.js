/** Short messages over the stage. */

const SECONDS = 4;
const SECONDS_FOR_ERRORS = 12;

let over;

/** Says that something was done. */
export function tell(text) {
  put(text, false);
}

/** Says what went wrong; stays longer. */
export function tellError(text) {
  put(text, true);
}

function put(text, isError) {
  const toast = document.querySelector("#toast");
  clearTimeout(over);
  toast.textContent = text;
  toast.classList.toggle("alarm", isError);
  toast.classList.add("shown");
  over = setTimeout(() => toast.classList.remove("shown"), 1000 * (isError ? SECONDS_FOR_ERRORS : SECONDS));
}
