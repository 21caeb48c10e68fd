/** How it looks, and how it is steered. */

import assert from "node:assert/strict";

/** Means of red, green, blue and opacity over the picture, and over its corner, in the page. */
const MEANS = `async (avatar) => {
  const bitmap = await createImageBitmap(await avatar.toBlob());
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d", { willReadFrequently: true });
  context.drawImage(bitmap, 0, 0);
  const mean = (x, y, width, height) => {
    const { data } = context.getImageData(x, y, width, height);
    const sums = [0, 0, 0, 0];
    for (let i = 0; i < data.length; i += 1) sums[i % 4] += data[i];
    return sums.map((sum) => Math.round((4 * sum) / data.length));
  };
  return { whole: mean(0, 0, bitmap.width, bitmap.height), corner: mean(0, 0, 16, 16) };
}`;

async function means({ withAvatar }) {
  return await withAvatar({ toString: () => MEANS });
}

async function set({ withAvatar }, attributes) {
  await withAvatar((avatar, wanted) => {
    for (const [name, value] of Object.entries(wanted)) avatar.setAttribute(name, value);
  }, attributes);
}

const distance = (a, b) => Math.max(...a.map((x, i) => Math.abs(x - b[i])));

const BACKENDS = ["webgpu", "webgpu+cpu", "webgl2+cpu"];

export default [
  ...BACKENDS.map((backend) => ({
    name: `look: every view and environment is another picture (${backend})`,
    run: async (tools) => {
      await tools.mount({ backend, quality: "best", "camera-orbit": "20deg 83deg 2.6m" });
      const pictures = new Map();
      for (const view of ["detailed", "base", "body", "wireframe", "normals", "laplacian"]) {
        await set(tools, { view });
        pictures.set(view, await digest(tools));
      }
      await set(tools, { view: "detailed" });
      for (const environment of ["daylight", "sunset", "night"]) {
        await set(tools, { environment });
        pictures.set(environment, await digest(tools));
      }
      await set(tools, { environment: "studio", detail: "0" });
      pictures.set("detail 0", await digest(tools));
      assert.equal(pictures.get("detail 0"), pictures.get("base"), "without detail it is the base");
      pictures.delete("detail 0");
      await set(tools, { view: "detailed", detail: "1", liveliness: "0" });
      pictures.set("liveliness 0", await digest(tools));
      await set(tools, { liveliness: "1" });
      assert.equal(await digest(tools), pictures.get("detailed"), "back where it began");
      assert.equal(new Set(pictures.values()).size, pictures.size, JSON.stringify([...pictures]));
    },
  })),
  ...BACKENDS.map((backend) => ({
    name: `look: a background is that colour, and transparent keeps the shadow (${backend})`,
    run: async (tools) => {
      await tools.mount({ backend, background: "rgb(200 40 120)" });
      const { corner } = await means(tools);
      assert.ok(distance(corner, [200, 40, 120, 255]) <= 2, String(corner));
      await set(tools, { background: "transparent" });
      const clear = await means(tools);
      assert.equal(clear.corner[3], 0);
      assert.ok(clear.whole[3] > 5 && clear.whole[3] < 250, String(clear.whole));
      await set(tools, { shadow: "0" });
      const bare = await means(tools);
      assert.ok(bare.whole[3] < clear.whole[3], "without a shadow there is less of the picture");
    },
  })),
  {
    name: "look: the camera goes where it is told, and says where it is",
    run: async ({ mount, withAvatar }) => {
      await mount({ "camera-orbit": "90deg 80deg 3m", "camera-target": "0m 1.2m 0.1m", "field-of-view": "20deg" });
      const told = await withAvatar(async (avatar) => {
        const orbit = avatar.getCameraOrbit();
        const { x, y, z } = avatar.getCameraTarget();
        const first = [orbit.theta, orbit.phi, orbit.radius, x, y, z, avatar.getFieldOfView()];
        const moved = next(avatar, "camera-change");
        avatar.cameraOrbit = "0deg auto auto";
        avatar.jumpCameraToGoal();
        await moved;
        return { first, theta: avatar.getCameraOrbit().theta, text: orbit.toString() };
      });
      const expected = [Math.PI / 2, (80 * Math.PI) / 180, 3, 0, 1.2, 0.1, 20];
      assert.ok(distance(told.first, expected) < 1e-3, String(told.first));
      assert.ok(Math.abs(told.theta) < 1e-3, String(told.theta));
      assert.match(told.text, /^1\.5708rad 1\.3963rad 3\.000m$/u);
    },
  },
  {
    name: "look: keys orbit, play and step; the picture takes the focus and says what it is",
    run: async ({ mount, withAvatar, page }) => {
      await mount({ "camera-controls": true, alt: "A dancer", fps: 4, loop: true });
      await page.keyboard.press("Tab");
      const picture = await withAvatar((avatar) => {
        const focused = avatar.shadowRoot.activeElement;
        return {
          role: focused.getAttribute("role"),
          label: focused.getAttribute("aria-label"),
          ring: getComputedStyle(focused).outlineStyle,
        };
      });
      assert.deepEqual(picture, { role: "application", label: "A dancer", ring: "solid" });
      const before = await withAvatar((avatar) => avatar.getCameraOrbit().theta);
      await page.keyboard.press("ArrowRight");
      await withAvatar((avatar, theta) => until(() => avatar.getCameraOrbit().theta > theta + 0.19), before);
      await page.keyboard.press(".");
      await withAvatar((avatar) => until(() => avatar.currentTime === 0.25));
      await page.keyboard.press(" ");
      assert.equal(await withAvatar((avatar) => avatar.paused), false);
      await page.keyboard.press(" ");
      assert.equal(await withAvatar((avatar) => avatar.paused), true);
      assert.equal(
        await withAvatar((avatar) => avatar.shadowRoot.querySelector("[role=status]").textContent),
        "Paused",
      );
    },
  },
  {
    name: "look: a drag orbits and the wheel zooms, but a page that scrolls keeps its wheel",
    run: async ({ mount, withAvatar, page }) => {
      await mount({ "camera-controls": true });
      const orbit = () => withAvatar((avatar) => ({ ...avatar.getCameraOrbit() }));
      const first = await orbit();
      await page.mouse.move(160, 160);
      await page.mouse.down();
      await page.mouse.move(100, 160, { steps: 4 });
      await page.mouse.up();
      await withAvatar((avatar, theta) => until(() => avatar.getCameraOrbit().theta > theta + 0.5), first.theta);
      await page.mouse.wheel(0, 300);
      await withAvatar((avatar, radius) => until(() => avatar.getCameraOrbit().radius > 1.3 * radius), first.radius);
      await withAvatar(async (avatar) => {
        avatar.shadowRoot.activeElement?.blur();
        document.body.style.blockSize = "5000px";
        // On a busy machine pictures are rare: at rest is what stays for several of them.
        for (let last = 0, still = 0; still < 5; await sleep(300)) {
          const { radius } = avatar.getCameraOrbit();
          still = radius === last ? still + 1 : 0;
          last = radius;
        }
      });
      const { radius } = await orbit();
      await page.mouse.wheel(0, 300);
      await withAvatar(() => until(() => scrollY > 100));
      const after = (await orbit()).radius;
      assert.ok(Math.abs(after - radius) < 0.01 * radius, `${radius} m before, ${after} m after`);
    },
  },
  {
    name: "look: two fingers pinch, and one that goes down scrolls the page",
    context: { hasTouch: true },
    run: async ({ mount, withAvatar, page, context }) => {
      await mount({ "camera-controls": true });
      await withAvatar(() => {
        document.body.style.blockSize = "5000px";
      });
      const session = await context.newCDPSession(page);
      const { theta, radius } = await withAvatar((avatar) => ({ ...avatar.getCameraOrbit() }));
      await touch(session, "touchStart", [
        [140, 160],
        [180, 160],
      ]);
      for (const spread of [40, 60, 80])
        await touch(session, "touchMove", [
          [160 - spread, 160],
          [160 + spread, 160],
        ]);
      await touch(session, "touchEnd", []);
      await withAvatar((avatar, radius) => until(() => avatar.getCameraOrbit().radius < 0.7 * radius), radius);
      await touch(session, "touchStart", [[60, 160]]);
      for (const x of [90, 130, 180]) await touch(session, "touchMove", [[x, 160]]);
      await touch(session, "touchEnd", []);
      await withAvatar((avatar, theta) => until(() => Math.abs(avatar.getCameraOrbit().theta - theta) > 0.3), theta);
      // Last, as the page glides on after it, and what touches a gliding page stops it first.
      await touch(session, "touchStart", [[160, 250]]);
      for (const y of [230, 190, 130, 60]) await touch(session, "touchMove", [[160, y]]);
      await touch(session, "touchEnd", []);
      await withAvatar(() => until(() => scrollY > 50));
    },
  },
  {
    name: "look: slots take the page's own poster, bar, controls and fallback",
    run: async ({ mount, withAvatar }) => {
      await mount({ src: "/bad/never.glb" }, { ready: false });
      const told = await withAvatar(async (avatar) => {
        const own = (slot) => {
          const element = document.createElement("p");
          element.slot = slot;
          element.textContent = slot;
          avatar.append(element);
          return element;
        };
        const [poster, bar, controls] = ["poster", "progress-bar", "controls"].map(own);
        await next(avatar, "progress");
        const loading = [poster, bar, controls].map((element) => element.checkVisibility({ visibilityProperty: true }));
        avatar.src = TINY;
        await avatar.ready;
        const hidden = (element) => !element.checkVisibility({ visibilityProperty: true, opacityProperty: true });
        await until(() => hidden(poster) && hidden(bar));
        return { loading, controls: controls.checkVisibility() };
      });
      assert.deepEqual(told, { loading: [true, true, true], controls: true });
    },
  },
  {
    name: "look: the bar of controls plays, scrubs and tells the time, where it is asked for and there is a motion",
    run: async ({ page, mount, withAvatar }) => {
      await mount();
      const bar = page.locator("crease-avatar .transport");
      assert.equal(await bar.isVisible(), false, "nobody asked for it");
      const duration = await withAvatar((avatar) => {
        avatar.controls = true;
        window.heard = listen(avatar, ["input", "change", "seeked"]);
        return avatar.duration;
      });
      await page.getByRole("button", { name: "Play", exact: true }).click();
      await page.getByRole("button", { name: "Pause", exact: true }).click();
      assert.equal(await withAvatar((avatar) => avatar.paused), true);
      const scrub = page.getByRole("slider", { name: "Time" });
      await scrub.fill(String(duration / 2));
      await page.waitForFunction(() => window.heard.includes("seeked"));
      assert.equal(await withAvatar((avatar) => avatar.currentTime), duration / 2);
      assert.equal(
        await withAvatar(() => window.heard.some((name) => name !== "seeked")),
        false,
        "it is not a field of the page",
      );
      const spoken = `${(duration / 2).toFixed(1)} of ${duration.toFixed(1)} seconds`;
      assert.equal(await scrub.getAttribute("aria-valuetext"), spoken);
      await withAvatar((avatar) => avatar.removeAttribute("motion"));
      await bar.waitFor({ state: "hidden" });
    },
  },
  {
    name: "look: it turns by itself, unless reduced motion is preferred",
    run: async ({ mount, withAvatar, page }) => {
      await mount({ "auto-rotate": true, "rotation-per-second": "90deg" });
      await withAvatar(async (avatar) => {
        const { theta } = avatar.getCameraOrbit();
        await until(() => avatar.getCameraOrbit().theta - theta > 0.1);
      });
      const turned = () =>
        withAvatar(async (avatar) => {
          const { theta } = avatar.getCameraOrbit();
          await sleep(600);
          return avatar.getCameraOrbit().theta - theta;
        });
      await page.emulateMedia({ reducedMotion: "reduce" });
      await withAvatar((avatar) => {
        avatar.rotationPerSecond = "80deg";
      });
      await turned();
      assert.equal(await turned(), 0);
    },
  },
  {
    name: "look: the poster covers the picture until it is revealed as asked",
    run: async ({ mount, withAvatar, page }) => {
      await mount({
        reveal: "interaction",
        poster: "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg'/%3E",
      });
      const covered = () =>
        withAvatar((avatar) => !avatar.shadowRoot.querySelector(".poster").classList.contains("gone"));
      assert.equal(await covered(), true);
      await page.mouse.click(100, 100);
      assert.equal(await covered(), false);
      await withAvatar((avatar) => avatar.showPoster());
      assert.equal(await covered(), true);
      await withAvatar((avatar) => avatar.dismissPoster());
      assert.equal(await covered(), false);
    },
  },
];

/** A touch of some fingers through the browser's own input. */
async function touch(session, type, points) {
  const touchPoints = points.map(([x, y], id) => ({ x, y, id }));
  await session.send("Input.dispatchTouchEvent", { type, touchPoints });
}

/** A short name of the picture's every pixel. */
async function digest({ withAvatar }) {
  return await withAvatar(async (avatar) => {
    avatar.jumpCameraToGoal();
    const bytes = await (await avatar.toBlob()).arrayBuffer();
    // FNV-1a: pages on plain http have no crypto.subtle everywhere.
    let hash = 0x811c9dc5;
    for (const byte of new Uint8Array(bytes)) hash = Math.imul(hash ^ byte, 0x01000193);
    return hash >>> 0;
  });
}
