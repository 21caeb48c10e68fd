/** Light and dark: as the system says, until the visitor says otherwise. */

const KEY = "crease-theme";

export function setUpTheme(avatar) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const put = (theme) => {
    document.documentElement.style.colorScheme = theme;
    avatar.theme = theme;
  };
  const kept = remembered();
  if (kept === "light" || kept === "dark") put(kept);
  document.querySelector("#theme").addEventListener("click", () => {
    const now = document.documentElement.style.colorScheme || (system.matches ? "dark" : "light");
    const next = now === "dark" ? "light" : "dark";
    put(next);
    remember(next);
  });
}

function remembered() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    // A browser that keeps nothing.
    return null;
  }
}

function remember(theme) {
  try {
    localStorage.setItem(KEY, theme);
  } catch {
    // As above: the choice lasts for this visit.
  }
}
