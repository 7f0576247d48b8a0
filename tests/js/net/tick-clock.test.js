// The clock: which tick is drawn when, despite jitter, drift and sleep.

import assert from "node:assert/strict";
import { test } from "node:test";

import { TickClock } from "../../../static/js/net/tick-clock.js";
import { chance, near } from "../support.js";

/** The ticks drawn at local times, given [tick, arrival] of messages; before some of them the room slept. */
function shownTicks(stamps, times, wakings = []) {
  const clock = new TickClock({ rate: 60 });
  let next = 0;
  return times.map((now) => {
    for (; next < stamps.length && stamps[next][1] <= now; next += 1) {
      if (wakings.includes(next)) clock.restart();
      clock.observe(...stamps[next]);
    }
    return clock.renderTick(now);
  });
}

const range = (count, value) => Array.from({ length: count }, (_, i) => value(i));

test("the picture stays three ticks behind a steady server", () => {
  const stamps = range(300, (tick) => [tick, 1000 + (tick * 1000) / 60]);
  const times = range(699, (i) => 1000 + ((i + 1) * 1000) / 144);
  shownTicks(stamps, times).forEach((tick, i) => {
    near(tick, ((times[i] - 1000) * 60) / 1000 - 3, 0.05);
  });
});

test("the picture never runs backwards despite jitter and drift", () => {
  const random = chance(3);
  const fast = 1.002; // the server's clock gains two seconds in a thousand
  let arrived = 0;
  const stamps = range(60 * 120, (tick) => {
    const late = -6 * Math.log(1 - random()); // ms, exponential
    arrived = Math.max(arrived, (tick * 1000) / 60 / fast + late);
    return [tick, arrived];
  });
  const times = range(60 * 115, (i) => 200 + (i * 1000) / 60);
  const ticks = shownTicks(stamps, times);
  const steps = ticks.slice(1).map((tick, i) => tick - ticks[i]).slice(1);
  assert.ok(Math.min(...steps) >= 0.9 - 1e-6, `${Math.min(...steps)}`);
  assert.ok(Math.max(...steps) <= 1.1 + 1e-6, `${Math.max(...steps)}`);
  const behind = times.map((now, i) => (now * 60 * fast) / 1000 - ticks[i]).slice(600);
  assert.ok(Math.max(...behind) < 18, `${Math.max(...behind)}`);
  assert.ok(Math.min(...behind) > 2, "the drift of 14 ticks was followed");
});

test("a room that wakes is shown at its tick again", () => {
  const stamps = range(100, (tick) => [tick, (tick * 1000) / 60]);
  const woken = stamps.length;
  stamps.push(...range(100, (tick) => [100 + tick, 60_000 + (tick * 1000) / 60]));
  const times = [...range(99, (i) => ((i + 1) * 1000) / 60), 60_100, 60_200];
  near(shownTicks(stamps, times, [woken]).at(-1), 100 + 12 - 3, 0.6);
});
