import assert from "node:assert/strict";
import { test } from "node:test";
import { candidates, once, openFirst } from "../dist/internal/backend.js";

test("a choice starts at itself and goes on with slower backends", () => {
  assert.deepEqual(candidates("webgpu"), ["webgpu", "webgpu+cpu", "webgl2+cpu"]);
  assert.deepEqual(candidates("webgl2+cpu"), ["webgl2+cpu"]);
  assert.equal(candidates("auto").at(-1), "webgl2+cpu");
});

test("the first backend that works is opened, and the reasons of the others are told", async () => {
  const told = [];
  const open = async (backend) => {
    if (backend === "webgpu+cpu") throw new Error("maxBufferSize: expected 268435456, found 1024");
    return `opened ${backend}`;
  };
  const opened = await openFirst(["webgpu+cpu", "webgl2+cpu"], open, (message) => told.push(message));
  assert.deepEqual(opened, { backend: "webgl2+cpu", value: "opened webgl2+cpu" });
  assert.equal(told.length, 1);
  assert.match(told[0], /webgpu\+cpu: maxBufferSize: expected 268435456, found 1024\. Using webgl2\+cpu/);
});

test("where nothing works the error has all reasons", async () => {
  const open = async (backend) => {
    throw new Error(`no ${backend}`);
  };
  await assert.rejects(
    openFirst(["webgpu+cpu", "webgl2+cpu"], open, () => {}),
    {
      code: "unsupported",
      message: /no webgpu\+cpu.*no webgl2\+cpu/,
    },
  );
});

test("the same reason is told once", () => {
  const told = [];
  const tell = once((message) => told.push(message));
  for (const message of ["a", "b", "a"]) tell(message);
  assert.deepEqual(told, ["a", "b"]);
});
