/** A row of radio buttons that looks like one switch. */

/** Fills `place` with `options` ({ value, name }); calls `onChoose` with a value. Returns a function that shows a value as chosen. */
export function fillChoices(place, group, options, onChoose) {
  const inputs = options.map(({ value, name }) => {
    const label = document.createElement("label");
    const input = document.createElement("input");
    input.type = "radio";
    input.name = group;
    input.value = value;
    input.autocomplete = "off";
    input.addEventListener("change", () => onChoose(value));
    const text = document.createElement("span");
    text.textContent = name;
    label.append(input, text);
    place.append(label);
    return input;
  });
  return (value) => {
    for (const input of inputs) input.checked = input.value === value;
  };
}
