/** The server of the browser cases: the repository's files, and answers as bad servers give them. Remembers what was asked for. */

import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const ROOT = fileURLToPath(new URL("../../../", import.meta.url));

const MEDIA_TYPES = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".wasm": "application/wasm",
  ".glb": "model/gltf-binary",
  ".png": "image/png",
  ".svg": "image/svg+xml",
};

/** An empty page that knows the element. `strict` as its query adds the documented policy, `isolated` the headers that keep other sites away. */
const BLANK = `<!doctype html><html lang="en"><head><meta charset="utf-8"><title>A case</title>
<link rel="stylesheet" href="/case.css">
<script type="module" src="/web/dist/public/crease-avatar.js"></script></head><body></body></html>`;
const STYLE = "body { margin: 0; } crease-avatar { display: block; width: 320px; height: 320px; }";
const ISOLATION = {
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Embedder-Policy": "require-corp",
};
/** Read from the page that recommends it: what is recommended is what was tried. */
const POLICY = /^Content-Security-Policy: (.+)$/mu.exec(await readFile(join(ROOT, "docs/self-hosting.md"), "utf8"))[1];

/** Starts it; `other` is a second origin, whose files are not shared with the first. */
export async function startServer() {
  const requests = [];
  const held = new Set();
  /** What is sent in place of a file, by its path: `{ status, type, body, change, broken }`, all of them optional. */
  const instead = new Map();
  const answer = async (request, response) => {
    const url = new URL(request.url, "http://localhost");
    // Browsers ask for it by themselves.
    if (url.pathname !== "/favicon.ico") requests.push(url.pathname);
    // The page's workers need what the page has.
    const isolated = url.search === "?isolated" || request.headers.referer?.endsWith("?isolated");
    const send = (status, type, body, headers = {}) => {
      const all = { "Content-Type": type, "Cache-Control": "no-store", ...(isolated ? ISOLATION : {}), ...headers };
      response.writeHead(status, all);
      response.end(body);
    };
    switch (url.pathname) {
      case "/blank.html":
        return send(
          200,
          MEDIA_TYPES[".html"],
          BLANK,
          url.search === "?strict" ? { "Content-Security-Policy": POLICY } : {},
        );
      case "/favicon.ico":
        return send(204, "image/x-icon", "");
      case "/case.css":
        return send(200, "text/css", STYLE);
      case "/bad/missing.glb":
        return send(404, "text/plain", "There is no such file.");
      case "/bad/page.glb":
        return send(200, MEDIA_TYPES[".html"], BLANK);
      case "/bad/noise.glb":
        return send(200, MEDIA_TYPES[".glb"], Buffer.alloc(512, 7));
      case "/bad/broken-off.glb":
        response.writeHead(200, { "Content-Type": MEDIA_TYPES[".glb"], "Content-Length": "100000" });
        response.write(Buffer.alloc(1000));
        setTimeout(() => response.destroy(), 50);
        return;
      case "/bad/never.glb":
        response.writeHead(200, { "Content-Type": MEDIA_TYPES[".glb"], "Content-Length": "100000" });
        response.write(Buffer.alloc(1000));
        held.add(url.pathname);
        response.on("close", () => held.delete(url.pathname));
        return;
    }
    // Below /shared/ lie the same files, for every origin.
    const shared = url.pathname.startsWith("/shared/");
    const path = normalize(decodeURIComponent(shared ? url.pathname.slice("/shared".length) : url.pathname));
    if (!/^\/(?:web\/(?:dist|pkg|assets)|tests)\//u.test(path)) return send(404, "text/plain", "Not here.");
    try {
      const answer = instead.get(path) ?? {};
      const { status = 200, type, change = (bytes) => bytes, broken = false } = answer;
      const body = change(answer.body ?? (await readFile(join(ROOT, path))));
      const headers = shared ? { "Access-Control-Allow-Origin": "*" } : {};
      if (broken) {
        response.writeHead(200, { "Content-Type": MEDIA_TYPES[extname(path)], "Content-Length": body.length });
        response.write(body.subarray(0, body.length / 2));
        setTimeout(() => response.destroy(), 50);
        return;
      }
      return send(status, type ?? MEDIA_TYPES[extname(path)] ?? "application/octet-stream", body, headers);
    } catch {
      return send(404, "text/plain", "There is no such file.");
    }
  };
  const listen = async () => {
    const server = createServer((request, response) => void answer(request, response));
    await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
    return server;
  };
  const [server, other] = [await listen(), await listen()];
  const origin = (of) => `http://127.0.0.1:${of.address().port}`;
  return {
    origin: origin(server),
    otherOrigin: origin(other),
    requests,
    held,
    instead,
    close: () => {
      for (const one of [server, other]) {
        one.closeAllConnections();
        one.close();
      }
    },
  };
}
