/** Examples run on the page itself, when somebody asks for it. */

for (const link of document.querySelectorAll(".run a")) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = link.textContent;
  button.addEventListener("click", () => {
    const running = button.parentElement.querySelector("iframe");
    if (running) {
      running.remove();
    } else {
      const frame = document.createElement("iframe");
      frame.title = "The example above, running";
      frame.src = link.href;
      button.before(frame);
    }
    button.textContent = running ? "Run it" : "Stop";
  });
  link.replaceWith(button);
}
