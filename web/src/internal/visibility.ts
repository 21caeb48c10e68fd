/** Tells whether `element` can be seen: on screen, in a page that is not hidden. Returns a function that stops it. */
export function watchVisibility(element: Element, onChange: (visible: boolean) => void): () => void {
  let onScreen = false;
  let last: boolean | null = null;
  const update = (): void => {
    const visible = onScreen && document.visibilityState === "visible";
    if (visible !== last) onChange(visible);
    last = visible;
  };
  const observer = new IntersectionObserver((entries) => {
    onScreen = entries.at(-1)?.isIntersecting ?? onScreen;
    update();
  });
  observer.observe(element);
  document.addEventListener("visibilitychange", update);
  return () => {
    observer.disconnect();
    document.removeEventListener("visibilitychange", update);
  };
}

/** Tells `element`'s size in pixels of the device, at most `longest` a side. Returns a function that stops it. */
export function watchSize(
  element: Element,
  longest: number,
  onChange: (width: number, height: number) => void,
): () => void {
  const observer = new ResizeObserver((entries) => {
    const box = entries.at(-1)?.contentRect;
    if (!box) return;
    // Beyond two device pixels a page pixel nobody sees a difference, but the GPU does.
    const ratio = Math.min(devicePixelRatio, 2);
    const scale = Math.min(ratio, longest / Math.max(box.width, box.height, 1));
    onChange(Math.round(box.width * scale), Math.round(box.height * scale));
  });
  observer.observe(element);
  return () => observer.disconnect();
}
