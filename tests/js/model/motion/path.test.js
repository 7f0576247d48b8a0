// One ball's path: late keyframes, missing keyframes, forgetting, and bounded memory.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Path } from "../../../../static/js/model/motion/path.js";
import { chance, near } from "../../support.js";
import { fall, G, keyframe, TICK } from "./falls.js";

const LAW = { gravity: G, drag: 0 };

function pathOf(moments, law = LAW) {
  const path = new Path(law);
  for (const moment of moments) path.add({ ...moment });
  return path;
}

test("a late contact gives the same path as one in time", () => {
  const a = keyframe(1, 0, 0, 1, 3, { angle: 6.2 });
  const corner = 1 + 0.4 * TICK;
  const { x, y, vx, vy } = fall(a, corner);
  const after = keyframe(corner, x, y, -vx, -0.7 * vy);
  const end = fall(after, 1 + TICK);
  const b = keyframe(1 + TICK, end.x, end.y, end.vx, end.vy, { bounced: true, angle: 0.1 });
  const contact = keyframe(corner, x, y, 0, 0, { vIn: false, vOut: false });
  const [inTime, late] = [pathOf([a, contact, b]), pathOf([a, b, contact])];
  for (let step = 0; step <= 20; step += 1) {
    const t = 1 + (TICK * step) / 20;
    const pose = { ...inTime.poseAt(t) };
    assert.deepEqual(pose, { ...late.poseAt(t) });
    const true_ = fall(t <= corner ? a : after, t);
    near(pose.x, true_.x, 1e-9);
    near(pose.y, true_.y, 1e-9);
    const turned = 6.2 + ((0.1 + 2 * Math.PI - 6.2) * (t - 1)) / TICK;
    near(Math.cos(pose.angle - turned), 1, 1e-12);
  }
});

test("without new keyframes a ball flies on a little, then waits", () => {
  const a = keyframe(1, 0, 0, 1, 1);
  const path = pathOf([a]);
  const soon = path.poseAt(1.03);
  near(soon.x, fall(a, 1.03).x, 1e-6);
  near(soon.y, fall(a, 1.03).y, 1e-6);
  assert.deepEqual({ ...path.poseAt(2) }, { ...path.poseAt(3) });
});

test("the path of a table that is not drawn is bounded", () => {
  const path = new Path(LAW, 600);
  for (let i = 0; i < 5000; i += 1) {
    path.add({ t: i / 60, x: 0, y: i, vx: 0, vy: 60, vIn: true, vOut: true });
  }
  assert.equal(path.keyframes.length, 600);
  near(path.keyframes[0].t, 4400 / 60, 1e-9);
  near(path.end, 4999 / 60, 1e-9);
});

test("forgetting keyframes does not move the rest of the path", () => {
  const random = chance(4);
  const moments = Array.from({ length: 60 }, (_, i) => ({
    t: i * TICK, x: random(), y: random(), vx: 4 * random() - 2, vy: 4 * random() - 2,
    vIn: i % 3 !== 1, vOut: i % 3 !== 1,
  }));
  const path = pathOf(moments, { gravity: G, drag: 0.5 });
  const times = Array.from({ length: 90 }, (_, step) => 0.51 + step / 200);
  const look = () => times.map((t) => ({ ...path.poseAt(t) }));
  const before = look();
  const stretches = [];
  path.forget(0.5, (a, b) => stretches.push([a.t, b.t]));
  assert.deepEqual(look(), before);
  assert.equal(stretches[0][0], 0);
  assert.ok(stretches.at(-1)[1] <= 0.5);
  stretches.slice(1).forEach(([from], i) => assert.equal(from, stretches[i][1]));
});
