/** Play, pause, time, speed. */

export function setUpTransport(avatar) {
  const part = (id) => document.getElementById(id);
  const [play, time, now, length, rate] = ["play", "time", "now", "length", "rate"].map(part);

  play.addEventListener("click", () => (avatar.paused ? avatar.play() : avatar.pause()));
  const showPlaying = () => {
    play.ariaPressed = String(!avatar.paused);
    play.ariaLabel = avatar.paused ? "Play" : "Pause";
  };
  const showTime = () => {
    if (!time.matches(":active")) time.valueAsNumber = avatar.currentTime;
    now.textContent = clock(avatar.currentTime);
    time.ariaValueText = `${avatar.currentTime.toFixed(1)} seconds`;
  };
  for (const event of ["play", "pause", "ended"]) avatar.addEventListener(event, showPlaying);
  for (const event of ["timeupdate", "seeked"]) avatar.addEventListener(event, showTime);
  avatar.addEventListener("durationchange", () => {
    time.max = avatar.duration || 1;
    length.textContent = clock(avatar.duration);
    showTime();
  });
  time.addEventListener("input", () => {
    avatar.currentTime = time.valueAsNumber;
    now.textContent = clock(time.valueAsNumber);
  });
  rate.addEventListener("change", () => {
    avatar.playbackRate = Number(rate.value);
  });
  showPlaying();
}

/** Minutes, seconds and tenths. */
function clock(seconds) {
  const tenths = Math.floor(10 * seconds);
  const minutes = Math.floor(tenths / 600);
  return `${minutes}:${((tenths % 600) / 10).toFixed(1).padStart(4, "0")}`;
}
