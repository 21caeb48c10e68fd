import assert from "node:assert/strict";
import { test } from "node:test";
import { failureOf, isPanic, StageError } from "../dist/internal/errors.js";

/** Function 0 traps; function 1, which is exported, calls it. */
const TRAPS = [
  [0x00, 0x61, 0x73, 0x6d, 0x01, 0x00, 0x00, 0x00],
  [0x01, 0x04, 0x01, 0x60, 0x00, 0x00],
  [0x03, 0x03, 0x02, 0x00, 0x00],
  [0x07, 0x05, 0x01, 0x01, 0x66, 0x00, 0x01],
  [0x0a, 0x0a, 0x02, 0x03, 0x00, 0x00, 0x0b, 0x04, 0x00, 0x10, 0x00, 0x0b],
].flat();

function thrownBy(run) {
  try {
    run();
  } catch (thrown) {
    return thrown;
  }
  throw new Error("expected something thrown");
}

test("a panic says through which functions it came, innermost first", async () => {
  const { instance } = await WebAssembly.instantiate(Uint8Array.from(TRAPS));
  const panic = thrownBy(instance.exports.f);
  assert.equal(isPanic(panic), true);
  assert.deepEqual(failureOf(panic, "a.glb"), {
    code: "internal",
    message: "unreachable in wasm function 0 < 1",
    url: "a.glb",
  });
});

test("a panic without a call stack keeps its own words", () => {
  const panic = new WebAssembly.RuntimeError("unreachable");
  panic.stack = undefined;
  assert.equal(failureOf(panic, null).message, "unreachable");
});

test("other errors keep code, message and address", () => {
  const typed = Object.assign(new Error("no GLB"), { code: "avatar" });
  assert.deepEqual(failureOf(typed, "a.glb"), { code: "avatar", message: "no GLB", url: "a.glb" });
  assert.deepEqual(failureOf(new StageError("http", "404", "b.glb"), "a.glb"), {
    code: "http",
    message: "404",
    url: "b.glb",
  });
  assert.deepEqual(failureOf("words", null), { code: "internal", message: "words", url: null });
});
