import assert from "node:assert/strict";
import { test } from "node:test";
import { collect, fileName } from "../dist/internal/fetch.js";

function response(chunks, headers) {
  const body = new ReadableStream({
    start(controller) {
      for (const chunk of chunks) controller.enqueue(new Uint8Array(chunk));
      controller.close();
    },
  });
  return new Response(body, { headers });
}

async function collected(chunks, headers) {
  const told = [];
  const bytes = await collect(response(chunks, headers), (loaded, total) => told.push([loaded, total]));
  return { bytes: [...bytes], told };
}

test("every piece is told, with the length that the server says", async () => {
  const { bytes, told } = await collected([[1, 2], [3]], { "content-length": "3" });
  assert.deepEqual(bytes, [1, 2, 3]);
  assert.deepEqual(told, [
    [2, 3],
    [3, 3],
  ]);
});

test("the length of a compressed body is unknown", async () => {
  const { bytes, told } = await collected([[1, 2, 3]], { "content-length": "2", "content-encoding": "gzip" });
  assert.deepEqual(bytes, [1, 2, 3]);
  assert.deepEqual(told, [[3, null]]);
});

test("a body longer than announced, or than the first guess, comes whole", async () => {
  assert.deepEqual((await collected([[1], [2, 3, 4]], { "content-length": "2" })).bytes, [1, 2, 3, 4]);
  const long = Array.from({ length: 40_000 }, (_, index) => index % 251);
  assert.deepEqual((await collected([long, long, long], {})).bytes, [...long, ...long, ...long]);
});

test("file names leave query and folders out", () => {
  assert.equal(fileName("https://a.b/c/d.glb?x=1#y"), "d.glb");
});

test("more bytes than allowed are refused, as soon as they are known of", async () => {
  const refused = (chunks, headers) =>
    collect(response(chunks, headers), () => {}, 3).then(
      () => null,
      (error) => error.code,
    );
  assert.equal(await refused([[1, 2, 3]], {}), null);
  assert.equal(
    await refused(
      [
        [1, 2],
        [3, 4],
      ],
      {},
    ),
    "too-large",
  );
  assert.equal(await refused([[1]], { "content-length": "4" }), "too-large");
});
