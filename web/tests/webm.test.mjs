import assert from "node:assert/strict";
import { test } from "node:test";
import { webm } from "../dist/internal/webm.js";

/** Elements of `bytes` from `from` to `to`: identifier, content; lengths are eight bytes here. */
function* elements(bytes, from = 0, to = bytes.length) {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  let at = from;
  while (at < to) {
    const width = Math.clz32(bytes[at]) - 23;
    let id = 0;
    for (let i = 0; i < width; i += 1) id = id * 256 + bytes[at + i];
    assert.equal(bytes[at + width], 1, "a length of eight bytes");
    const length = Number(view.getBigUint64(at + width) & ((1n << 56n) - 1n));
    const start = at + width + 8;
    assert.ok(start + length <= to, "an element ends within its parent");
    yield { id, content: bytes.subarray(start, start + length) };
    at = start + length;
  }
}

const chunk = (key, milliseconds) => ({ key, milliseconds, bytes: new Uint8Array([milliseconds & 255, 7]) });

test("frames lie in clusters that begin with key frames, each at its time", () => {
  const chunks = [chunk(true, 0), chunk(false, 33), chunk(true, 67), chunk(false, 100)];
  const [header, segment] = webm({ codec: "V_VP9", width: 64, height: 48, seconds: 0.133, chunks });
  assert.equal([...elements(header)][0].id, 0x1a45dfa3);
  const parts = [...elements([...elements(segment)][0].content)];
  const clusters = parts.filter(({ id }) => id === 0x1f43b675);
  assert.equal(clusters.length, 2);
  const times = clusters.flatMap(({ content }) => {
    const inner = [...elements(content)];
    const start = inner[0].content.reduce((sum, byte) => 256 * sum + byte, 0);
    return inner.slice(1).map(({ content: block }) => {
      const view = new DataView(block.buffer, block.byteOffset);
      return [start + view.getInt16(1), block[3] === 0x80, block[4]];
    });
  });
  assert.deepEqual(times, [
    [0, true, 0],
    [33, false, 33],
    [67, true, 67],
    [100, false, 100],
  ]);
});

test("a gap longer than a block can count begins another cluster", () => {
  const chunks = [chunk(true, 0), chunk(false, 40_000)];
  const [, segment] = webm({ codec: "V_VP8", width: 2, height: 2, seconds: 40, chunks });
  const parts = [...elements([...elements(segment)][0].content)];
  assert.equal(parts.filter(({ id }) => id === 0x1f43b675).length, 2);
});
