import assert from "node:assert/strict";
import { test } from "node:test";
import { MediaState } from "../dist/internal/media-state.js";

function state() {
  const events = [];
  const wishes = [];
  const media = new MediaState({ tell: (event) => events.push(event), wish: (wish) => wishes.push(wish) });
  return { media, events, wishes };
}

test("a picture from before the latest wish says nothing", () => {
  const { media, wishes } = state();
  media.loaded(4);
  media.seek(3);
  media.hear({ order: wishes[0].order - 1, currentTime: 1, ended: false }, 0);
  assert.deepEqual([media.currentTime, media.seeking], [3, true]);
  media.hear({ order: wishes[0].order, currentTime: 3, ended: false }, 0);
  assert.deepEqual([media.currentTime, media.seeking], [3, false]);
});

test("an end that was on its way when playing started again is no end", () => {
  const { media, events, wishes } = state();
  media.loaded(4);
  media.play();
  media.hear({ order: 1, currentTime: 4, ended: true }, 0);
  assert.deepEqual(events, ["play", "timeupdate", "pause", "ended"]);
  media.play();
  media.hear({ order: 1, currentTime: 4, ended: true }, 0);
  assert.deepEqual([media.paused, media.ended], [false, false]);
  assert.deepEqual(wishes.at(-1), { order: 2, playing: true, seconds: null });
});

test("playing tells of time four times a second at most", () => {
  const { media, events } = state();
  media.loaded(4);
  media.play();
  for (let now = 0; now <= 1000; now += 20) media.hear({ order: 1, currentTime: now / 1000, ended: false }, now);
  const updates = events.filter((event) => event === "timeupdate").length;
  assert.ok(updates >= 4 && updates <= 5, String(updates));
});

test("times are clamped to the motion once it is known", () => {
  const { media, events } = state();
  media.seek(9);
  assert.deepEqual([media.currentTime, media.wish.seconds, events], [9, 9, []]);
  media.loaded(4);
  assert.equal(media.currentTime, 4);
  media.seek(-1);
  assert.equal(media.currentTime, 0);
  assert.ok(Number.isNaN(state().media.duration));
});
