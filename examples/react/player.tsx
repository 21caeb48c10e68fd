import type { CreaseAvatarElement } from "crease-avatar";
import "crease-avatar";
import { useEffect, useRef, useState } from "react";

/** An avatar with a slider for its wrinkles. */
export function Player() {
  const avatar = useRef<CreaseAvatarElement>(null);
  const [detail, setDetail] = useState(1);
  const [message, setMessage] = useState("Loading …");

  useEffect(() => {
    const leave = new AbortController();
    avatar.current?.addEventListener("load", () => setMessage("Playing"), leave);
    avatar.current?.addEventListener("error", ({ error }) => setMessage(error.message), leave);
    return () => leave.abort();
  }, []);

  return (
    <>
      <crease-avatar
        ref={avatar}
        src="avatar.glb"
        motion="dance.pkl"
        fps={60}
        detail={detail}
        autoplay
        loop
        camera-controls
        alt="A person dancing"
      />
      <label>
        Detail{" "}
        <input
          type="range"
          min="0"
          max="2"
          step="0.1"
          value={detail}
          onChange={(event) => setDetail(event.target.valueAsNumber)}
        />
      </label>
      <p role="status">{message}</p>
    </>
  );
}
