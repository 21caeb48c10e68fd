/** How strong the wrinkles are: none, as learned, twice. */

export function setUpDetail(avatar) {
  const slider = document.querySelector("#detail");
  const value = document.querySelector("#detail-value");
  slider.addEventListener("input", () => {
    avatar.detail = slider.valueAsNumber;
  });
  const show = () => {
    slider.valueAsNumber = avatar.detail;
    value.value = nameOf(avatar.detail);
    slider.ariaValueText = value.value;
  };
  new MutationObserver(show).observe(avatar, { attributeFilter: ["detail"] });
  show();
}

function nameOf(detail) {
  if (detail === 0) return "none";
  if (detail === 1) return "as learned";
  return `${detail.toFixed(2)} ×`;
}
