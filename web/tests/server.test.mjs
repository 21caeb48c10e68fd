import assert from "node:assert/strict";
import { test } from "node:test";

test("on a server the package can be imported and touches no DOM", async () => {
  assert.equal(typeof document, "undefined");
  const { CreaseAvatarElement, CreaseError } = await import("../dist/public/crease-avatar.js");
  assert.ok(CreaseAvatarElement.observedAttributes.includes("src"));
  assert.equal(new CreaseError("network", "no answer", null).code, "network");
});
