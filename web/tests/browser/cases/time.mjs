/** Time, with the meaning that HTML's media elements give it. */

import assert from "node:assert/strict";
import { longMotion } from "../motion-file.mjs";

export default [
  {
    name: "time: attributes and properties say the same",
    run: async ({ mount, withAvatar }) => {
      await mount();
      const told = await withAvatar((avatar) => {
        avatar.playbackRate = 0.5;
        avatar.loop = true;
        avatar.crossfade = 0.7;
        avatar.setAttribute("fps", "50");
        return {
          rate: avatar.getAttribute("playback-rate"),
          loop: avatar.getAttribute("loop"),
          crossfade: avatar.getAttribute("crossfade"),
          fps: avatar.fps,
          paused: avatar.paused,
          ended: avatar.ended,
        };
      });
      assert.deepEqual(told, { rate: "0.5", loop: "", crossfade: "0.7", fps: 50, paused: true, ended: false });
    },
  },
  {
    name: "time: values beyond their range are clamped, and what is no number is refused",
    run: async ({ mount, withAvatar }) => {
      await mount();
      const told = await withAvatar(async (avatar) => {
        avatar.detail = 7;
        avatar.liveliness = -3;
        avatar.playbackRate = -99;
        avatar.shadow = 3;
        avatar.currentTime = 1e9;
        await next(avatar, "seeked");
        const refused = ["currentTime", "playbackRate", "detail", "liveliness"].filter((name) => {
          try {
            avatar[name] = Number.NaN;
            return false;
          } catch (error) {
            return error instanceof TypeError;
          }
        });
        const { detail, liveliness, playbackRate, shadow, currentTime, duration } = avatar;
        return { detail, liveliness, playbackRate, shadow, atEnd: currentTime === duration, refused };
      });
      assert.deepEqual(told, {
        detail: 2,
        liveliness: 0,
        playbackRate: -16,
        shadow: 1,
        atEnd: true,
        refused: ["currentTime", "playbackRate", "detail", "liveliness"],
      });
    },
  },
  {
    name: "time: duration is unknown, then the motion's, then that of all motions less their crossfades",
    run: async ({ mount, withAvatar }) => {
      await mount({}, { ready: false });
      assert.ok(Number.isNaN(await withAvatar((avatar) => avatar.duration)));
      const one = await withAvatar(async (avatar) => {
        await avatar.ready;
        return [avatar.duration, avatar.seekable.length, avatar.seekable.start(0), avatar.seekable.end(0)];
      });
      const [duration] = one;
      assert.ok(duration > 0);
      assert.deepEqual(one, [duration, 1, 0, duration]);
      const [playlist, index] = await withAvatar(async (avatar) => {
        avatar.crossfade = 0.1;
        avatar.motion = `${MOTION} ${MOTION}`;
        await next(avatar, "durationchange");
        const { duration } = avatar;
        avatar.currentTime = duration;
        await next(avatar, "seeked");
        return [duration, avatar.motionIndex];
      });
      assert.ok(Math.abs(playlist - (2 * duration - 0.1)) < 1e-5, `${playlist} of twice ${duration}`);
      assert.equal(index, 1);
      const none = await withAvatar(async (avatar) => {
        avatar.motion = null;
        await next(avatar, "durationchange");
        return [avatar.duration, avatar.seekable.length];
      });
      assert.deepEqual(none, [0, 0]);
    },
  },
  {
    name: "time: a seek says seeking, then timeupdate and seeked, and shows the time at once",
    run: async ({ mount, withAvatar }) => {
      await mount();
      const told = await withAvatar(async (avatar) => {
        const heard = listen(avatar, ["seeking", "timeupdate", "seeked", "play", "pause"]);
        avatar.currentTime = 0.25;
        const at = [avatar.currentTime, avatar.seeking];
        await next(avatar, "seeked");
        return { heard, at, after: [avatar.currentTime, avatar.seeking, avatar.paused] };
      });
      assert.deepEqual(told.heard, ["seeking", "timeupdate", "seeked"]);
      assert.deepEqual(
        [told.at, told.after],
        [
          [0.25, true],
          [0.25, false, true],
        ],
      );
    },
  },
  {
    name: "time: a time that was set before the avatar came is where it starts",
    run: async ({ open, page }) => {
      await open();
      const time = await page.evaluate(async () => {
        const avatar = make();
        avatar.currentTime = 0.3;
        document.body.append(avatar);
        await avatar.ready;
        return avatar.currentTime;
      });
      assert.equal(time, 0.3);
    },
  },
  {
    name: "time: a motion that does not loop ends, and starts over when it is played",
    run: async ({ mount, withAvatar }) => {
      await mount({ fps: 1, "playback-rate": 16 });
      const told = await withAvatar(async (avatar) => {
        const heard = listen(avatar, ["play", "pause", "ended"]);
        void avatar.play();
        await next(avatar, "ended");
        const end = [avatar.ended, avatar.paused, avatar.currentTime === avatar.duration];
        avatar.playbackRate = 0.1;
        const again = next(avatar, "timeupdate");
        void avatar.play();
        await again;
        avatar.pause();
        return { heard, end, ended: avatar.ended, restarted: avatar.currentTime < avatar.duration };
      });
      assert.deepEqual(told.end, [true, true, true]);
      assert.deepEqual(told.heard, ["play", "pause", "ended", "play", "pause"]);
      assert.deepEqual([told.ended, told.restarted], [false, true]);
    },
  },
  {
    name: "time: a looping motion goes on, backwards too, and the rate is told of",
    run: async ({ mount, withAvatar }) => {
      await mount({ fps: 1, loop: true, autoplay: true });
      const told = await withAvatar(async (avatar) => {
        const rates = listen(avatar, ["ratechange", "ended"]);
        const times = [];
        avatar.playbackRate = -2;
        avatar.setAttribute("playback-rate", "-2");
        const until = performance.now() + 1000 * avatar.duration;
        while (performance.now() < until) {
          times.push(avatar.currentTime);
          await sleep(30);
        }
        return { rates, wrapped: times.some((time, i) => i > 0 && time > times[i - 1]), paused: avatar.paused };
      });
      assert.deepEqual(told, { rates: ["ratechange"], wrapped: true, paused: false });
    },
  },
  {
    name: "time: frames are stepped through one by one",
    run: async ({ mount, withAvatar }) => {
      await mount({ fps: 4 });
      const times = await withAvatar(async (avatar) => {
        const times = [];
        for (const frames of [1, 1, -1, -9]) {
          const done = next(avatar, "seeked");
          avatar.stepFrames(frames);
          await done;
          times.push(avatar.currentTime);
        }
        return times;
      });
      assert.deepEqual(times, [0.25, 0.5, 0.25, 0]);
    },
  },
  {
    name: "time: a motion of an hour plays and is sought in without more memory",
    run: async ({ server, mount, withAvatar }) => {
      server.instead.set("/tests/hour.npz", { body: longMotion(3600, 60) });
      await mount({ motion: "/tests/hour.npz", fps: null, quality: "best" });
      const told = await withAvatar(async (avatar) => {
        const places = [];
        // In no order, so that nothing can be kept from one for the next.
        for (let i = 0; i < 21; i += 1) {
          const sought = next(avatar, "seeked");
          const wanted = (3600 * ((8 * i + 5) % 21)) / 20.5;
          avatar.currentTime = wanted;
          await sought;
          places.push({ wanted, found: avatar.currentTime, bytes: avatar.statistics.memoryBytes });
        }
        const { currentTime } = avatar;
        void avatar.play();
        await until(() => avatar.currentTime > currentTime + 0.2);
        return { places, duration: avatar.duration, after: avatar.statistics.memoryBytes, ended: avatar.ended };
      });
      assert.equal(told.duration, 3600);
      assert.equal(told.ended, false);
      for (const { wanted, found } of told.places) {
        assert.ok(Math.abs(found - wanted) < 1 / 120, `sought ${wanted} s, found ${found} s`);
      }
      const [{ bytes }] = told.places;
      assert.deepEqual([...told.places.map((place) => place.bytes), told.after], Array(22).fill(bytes));
    },
  },
  {
    name: "time: a person who prefers reduced motion starts it",
    context: { reducedMotion: "reduce" },
    run: async ({ mount, withAvatar }) => {
      await mount({ autoplay: true, loop: true, fps: 20 });
      assert.ok(await withAvatar((avatar) => avatar.paused));
      await withAvatar(async (avatar) => {
        const moved = next(avatar, "timeupdate");
        void avatar.play();
        await moved;
      });
    },
  },
];
