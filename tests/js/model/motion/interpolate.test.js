// Between two keyframes the drawn flight is close to the exact one, and a bounce keeps its corner.

import assert from "node:assert/strict";
import { test } from "node:test";

import { poseBetween } from "../../../../static/js/model/motion/interpolate.js";
import { chance, near } from "../../support.js";
import { fall, G, keyframe, TICK } from "./falls.js";

const drawn = (a, b, t, drag = 0) => poseBetween(a, b, t, { gravity: G, drag });

function nearPlace(pose, place, tolerance) {
  near(pose.x, place.x, tolerance);
  near(pose.y, place.y, tolerance);
}

test("a parabola is drawn exactly", () => {
  const a = keyframe(2, 0.1, 0.5, 1.25, -2);
  const { x, y, vx, vy } = fall(a, 2 + TICK);
  const b = keyframe(2 + TICK, x, y, vx, vy);
  for (let step = 0; step <= 10; step += 1) {
    const t = 2 + (TICK * step) / 10;
    nearPlace(drawn(a, b, t), fall(a, t), 1e-12);
  }
});

test("a bounce is drawn to its corner", () => {
  const random = chance(1);
  const between = (low, high) => low + (high - low) * random();
  for (let i = 0; i < 300; i += 1) {
    const a = keyframe(1, 0, 0, between(-3, 3), between(0.5, 5));
    const corner = 1 + TICK * between(0.02, 0.98);
    const { x, y, vx, vy } = fall(a, corner);
    const after = keyframe(corner, x, y, vx + between(-2, 2), -between(0.3, 0.9) * vy);
    const end = fall(after, 1 + TICK);
    const b = keyframe(1 + TICK, end.x, end.y, end.vx, end.vy, { bounced: true });
    for (const t of [...Array.from({ length: 21 }, (_, step) => 1 + (TICK * step) / 20), corner]) {
      nearPlace(drawn(a, b, t), fall(t <= corner ? a : after, t), 1e-9);
    }
  }
});

test("with drag and rounding the corner is off by under 1 mm", () => {
  const random = chance(2);
  const between = (low, high) => low + (high - low) * random();
  const round = (value, steps) => Math.round(value * steps) / steps;
  const drag = 2.2;
  for (let i = 0; i < 300; i += 1) {
    const a = keyframe(1, 0, 0, between(-3, 3), between(0.5, 4));
    const corner = 1 + TICK * between(0.02, 0.98);
    const { x, y, vx, vy } = fall(a, corner, drag);
    const after = keyframe(corner, x, y, vx + between(-2, 2), -between(0.3, 0.9) * vy);
    const end = fall(after, 1 + TICK, drag);
    const b = keyframe(1 + TICK, round(end.x, 1e4), round(end.y, 1e4), round(end.vx, 1024),
      round(end.vy, 1024), { bounced: true });
    const pose = drawn(a, b, corner, drag);
    assert.ok(Math.hypot(pose.x - x, pose.y - y) < 1e-3);
  }
});

test("a bounce without its flag is found from the velocities", () => {
  const a = keyframe(1, 0, 0, 1, 3);
  const corner = 1 + 1.5 * TICK;
  const { x, y, vx, vy } = fall(a, corner);
  const after = keyframe(corner, x, y, vx, -0.7 * vy);
  const end = fall(after, 1 + 3 * TICK);
  const b = keyframe(1 + 3 * TICK, end.x, end.y, end.vx, end.vy);
  nearPlace(drawn(a, b, corner), { x, y }, 1e-9);
});
