import assert from "node:assert/strict";
import { test } from "node:test";
import { CameraOrbit, fieldOfViewOf, orbitOf, targetOf, turnOf } from "../dist/internal/camera-place.js";
import { addressesOf, clamp, environmentOf, finite, followOf, numberOf, viewOf } from "../dist/internal/options.js";

const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-9, `${a}, ${b}`);

test("an orbit has units, and auto where it is as usual", () => {
  const { azimuth, elevation, distance } = orbitOf("90deg 1.0rad 250cm");
  near(azimuth, Math.PI / 2);
  near(elevation, Math.PI / 2 - 1);
  assert.deepEqual(distance, { metres: 2.5 });
  assert.deepEqual(orbitOf("auto auto 105%"), { azimuth: null, elevation: null, distance: { share: 1.05 } });
  for (const text of [null, "", "auto", "90 80 3", "90m 80deg 3deg"]) {
    assert.equal(orbitOf(text).azimuth, null, String(text));
  }
});

test("what an orbit says is what the attribute takes", () => {
  const { azimuth, elevation, distance } = orbitOf(new CameraOrbit(0.35, 1.45, 4.9).toString());
  near(azimuth, 0.35);
  near(elevation, Math.PI / 2 - 1.45);
  assert.deepEqual(distance, { metres: 4.9 });
});

test("targets, fields of view and turns have units", () => {
  assert.deepEqual(targetOf("0m -10cm 2mm"), [0, -0.1, 0.002]);
  assert.equal(targetOf("0m 1m"), null);
  near(fieldOfViewOf("30deg"), Math.PI / 6);
  near(fieldOfViewOf("900deg"), (120 * Math.PI) / 180);
  assert.equal(fieldOfViewOf("auto"), null);
  near(turnOf("1rad"), 1);
  near(turnOf(null), (12 * Math.PI) / 180);
});

test("anything unknown is as without the attribute", () => {
  assert.deepEqual([viewOf("normals"), viewOf("x"), viewOf(null)], ["normals", "detailed", "detailed"]);
  assert.deepEqual([environmentOf("sunset"), environmentOf("")], ["sunset", "studio"]);
  assert.deepEqual([followOf(null), followOf(""), followOf("none")], ["soft", "root", "none"]);
  assert.deepEqual([numberOf("1e2", null), numberOf(" ", null), numberOf("1x", 7)], [100, null, 7]);
});

test("numbers are clamped, and what is none is refused", () => {
  assert.deepEqual([clamp(3, 0, 2), clamp(-3, 0, 2), clamp(1, 0, 2)], [2, 0, 1]);
  assert.throws(() => finite("x", "detail"), /detail: expected a finite number, found x/u);
});

test("a playlist is separated by white space", () => {
  assert.deepEqual(addressesOf(" a.pkl\n  b.npz "), ["a.pkl", "b.npz"]);
  assert.deepEqual(addressesOf(null), []);
});
