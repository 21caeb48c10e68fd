import assert from "node:assert/strict";
import { test } from "node:test";
import { FrameCounter, median } from "../dist/internal/statistics.js";

const frame = {
  order: 0,
  currentTime: 0,
  ended: false,
  motionIndex: 0,
  intervalMilliseconds: 16,
  poseMilliseconds: 10,
  partMilliseconds: [1, 2, 3, 4, 5, 6],
  drawMilliseconds: 2,
  iterations: 3,
  vertices: 7,
  quality: "best",
  detailSetupMilliseconds: 50,
  memoryBytes: 1024,
  gpuBytes: 2048,
};

test("the median of two is their middle, of none is null", () => {
  assert.equal(median([3, 1]), 2);
  assert.equal(median([9, 1, 2]), 2);
  assert.equal(median([]), null);
});

test("before the first frame there are no times", () => {
  const { frames, firstFrameMilliseconds, partMilliseconds, quality } = new FrameCounter().statistics();
  assert.deepEqual([frames, firstFrameMilliseconds, partMilliseconds.solve, quality], [0, null, null, null]);
});

test("pictures of the base come first, and the first one with detail has its own moment", () => {
  const counter = new FrameCounter();
  counter.count({ ...frame, detailSetupMilliseconds: null });
  const { firstFrameMilliseconds, ...base } = counter.statistics();
  assert.deepEqual([base.firstDetailMilliseconds, base.detailSetupMilliseconds], [null, null]);
  counter.count(frame);
  const detailed = counter.statistics();
  assert.equal(detailed.firstFrameMilliseconds, firstFrameMilliseconds);
  assert.ok(detailed.firstDetailMilliseconds >= firstFrameMilliseconds);
  assert.equal(detailed.detailSetupMilliseconds, 50);
});

test("each part has its median, and frames of the camera alone do not count into it", () => {
  const counter = new FrameCounter();
  counter.count(frame);
  counter.count({ ...frame, poseMilliseconds: null, partMilliseconds: null, drawMilliseconds: 4 });
  counter.count({ ...frame, partMilliseconds: [1, 2, 3, 4, 9, 6], quality: "high" });
  const told = counter.statistics();
  assert.deepEqual(told.partMilliseconds, { deformation: 1, base: 2, laplacian: 3, residual: 4, solve: 7, surface: 6 });
  assert.deepEqual([told.frames, told.drawMilliseconds, told.quality, told.iterations], [3, 2, "high", 3]);
});
