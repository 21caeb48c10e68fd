/** Who is dancing what; and, discreetly, what a frame costs and what computes it. */

const BACKENDS = {
  webgpu: "WebGPU",
  "webgpu+cpu": "WebGPU, posed on the CPU",
  "webgl2+cpu": "WebGL2, posed on the CPU",
};

export function setUpFigures(show) {
  const { avatar } = show;
  const caption = document.querySelector("#caption");
  const figures = document.querySelector("#figures");
  show.addEventListener("change", () => {
    caption.textContent = [show.person?.name, show.motion?.name].filter(Boolean).join(" · ");
  });
  avatar.addEventListener("timeupdate", () => {
    const { backend, frameMilliseconds, vertices } = avatar.statistics;
    if (vertices === 0) return;
    const parts = [`${vertices.toLocaleString("en")} vertices`, BACKENDS[backend] ?? backend];
    if (frameMilliseconds !== null) parts.push(`${frameMilliseconds.toFixed(0)} ms a frame`);
    figures.textContent = parts.filter(Boolean).join(" · ");
  });
}
