import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { Player } from "./player";

const root = document.getElementById("root");
if (root) {
  createRoot(root).render(
    <StrictMode>
      <Player />
    </StrictMode>,
  );
}
