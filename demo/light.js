/** The light on the figure. */

export function setUpLight(avatar) {
  const select = document.querySelector("#environment");
  select.addEventListener("change", () => {
    avatar.environment = select.value;
  });
  select.value = avatar.environment;
}
