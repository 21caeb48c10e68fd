/** Bad input: a typed error, the fallback shown, no half-state, and the next address works. */

import assert from "node:assert/strict";

/** The error of an element that cannot load, what is shown then, and whether another address works afterwards. */
async function failAndRecover({ mount, withAvatar, server }, attributes) {
  await mount({ src: null }, { ready: false });
  return await withAvatar(
    async (avatar, wanted) => {
      const fallback = document.createElement("p");
      fallback.slot = "fallback";
      fallback.textContent = "No avatar here.";
      avatar.append(fallback);
      const failed = next(avatar, "error");
      for (const [name, value] of Object.entries(wanted)) avatar.setAttribute(name, value);
      const { error } = await failed;
      const rejected = await avatar.ready.then(
        () => null,
        (reason) => reason,
      );
      const message = avatar.shadowRoot.querySelector("[part=message]");
      const shown = fallback.checkVisibility() && message.textContent.includes(error.message);
      const { canvas } = { canvas: avatar.shadowRoot.querySelector("canvas") };
      avatar.removeAttribute("max-bytes");
      avatar.src = TINY;
      await next(avatar, "load");
      return {
        code: error.code,
        message: error.message,
        url: error.url && new URL(error.url).pathname,
        same: rejected === error && avatar.error === null,
        shown,
        left: canvas !== null,
        gone: !fallback.checkVisibility(),
      };
    },
    Object.fromEntries(
      Object.entries(attributes).map(([name, value]) => [name, value.replace("OTHER", server.otherOrigin)]),
    ),
  );
}

function fatal(name, attributes, expected, allows = []) {
  return {
    name: `errors: ${name}`,
    allows,
    run: async (tools) => {
      const { message, ...told } = await failAndRecover(tools, attributes);
      assert.deepEqual(told, { ...expected, same: true, shown: true, left: false, gone: true });
      assert.match(message, /expected .+, found /u);
    },
  };
}

/** Something that the avatar can do without fails: it stays as it was. */
function harmless(name, change, expected, allows = []) {
  return {
    name: `errors: ${name}`,
    allows,
    run: async ({ mount, withAvatar }) => {
      await mount();
      const before = await withAvatar((avatar) => avatar.duration);
      const told = await withAvatar(async (avatar, wanted) => {
        const failed = next(avatar, "error");
        for (const [name, value] of Object.entries(wanted)) avatar.setAttribute(name, value);
        const { error } = await failed;
        const ready = await Promise.race([avatar.ready.then(() => true), sleep(1000)]);
        const done = next(avatar, "seeked");
        avatar.currentTime = 0.2;
        await done;
        return { code: error.code, url: error.url && new URL(error.url).pathname, ready, duration: avatar.duration };
      }, change);
      assert.deepEqual(told, { ...expected, ready: true, duration: before });
    },
  };
}

export default [
  fatal("status 404", { src: "/bad/missing.glb" }, { code: "http", url: "/bad/missing.glb" }, [/404/u]),
  fatal("a web page in place of a file", { src: "/bad/page.glb" }, { code: "type", url: "/bad/page.glb" }),
  fatal("a file that is no avatar", { src: "/bad/noise.glb" }, { code: "avatar", url: "/bad/noise.glb" }),
  fatal("a download that breaks off", { src: "/bad/broken-off.glb" }, { code: "network", url: "/bad/broken-off.glb" }, [
    /ERR_CONTENT_LENGTH_MISMATCH|ERR_CONNECTION|ERR_INCOMPLETE/u,
  ]),
  fatal(
    "a site that does not share its files",
    { src: "OTHER/tests/fixtures/tiny.glb" },
    { code: "network", url: "/tests/fixtures/tiny.glb" },
    [/CORS|ERR_FAILED/u],
  ),
  fatal(
    "a file that is larger than allowed",
    { "max-bytes": "1000", src: "/tests/fixtures/tiny.glb" },
    { code: "too-large", url: "/tests/fixtures/tiny.glb" },
  ),
  harmless(
    "a motion that is none",
    { motion: "/tests/fixtures/tiny.glb" },
    { code: "motion", url: "/tests/fixtures/tiny.glb" },
  ),
  harmless(
    "one missing motion of a playlist",
    { motion: "/tests/fixtures/pickles/motion-numpy2.pkl /bad/missing.glb" },
    { code: "http", url: "/bad/missing.glb" },
    [/404/u],
  ),
  harmless(
    "a texture that is no picture",
    { texture: "/tests/fixtures/pickles/motion-numpy2.pkl" },
    { code: "texture", url: "/tests/fixtures/pickles/motion-numpy2.pkl" },
  ),
  harmless(
    "wrinkles of something that is no avatar",
    { "detail-from": "/bad/noise.glb" },
    { code: "avatar", url: "/bad/noise.glb" },
  ),
];
