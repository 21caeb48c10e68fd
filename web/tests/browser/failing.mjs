/** Cases that must fail: whoever runs them sees that the runner can say so. */

import assert from "node:assert/strict";

export default [
  {
    name: "an avatar that does not exist becomes ready",
    allows: [/404/u],
    run: ({ mount }) => mount({ src: "/bad/missing.glb" }),
  },
  {
    name: "a page may complain on the console",
    run: async ({ open, page }) => {
      await open();
      await page.evaluate(() => console.warn("noise"));
    },
  },
  {
    name: "a wrong number counts as right",
    run: async ({ mount, withAvatar }) => {
      await mount();
      assert.equal(await withAvatar((avatar) => avatar.detail), 7);
    },
  },
];
