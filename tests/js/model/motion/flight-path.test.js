// Where a ball is on its path, and what it hits, compared with the golden file.

import assert from "node:assert/strict";
import { test } from "node:test";

import { LANDING, PEG, WALL } from "../../../../static/js/model/motion/drop.js";
import { FlightPath, joined, KNOT } from "../../../../static/js/model/motion/flight-path.js";
import { json, knotsOf, near } from "../../support.js";

const { messages } = json("tests/golden/paths.json");
const PEGS = Array.from({ length: 85 }, () => ({ x: 0, y: 0, radius: 0.05 }));

function pathOf({ knots }, drag = 0, y = 5.196) {
  return new FlightPath(knotsOf(knots), { drag, pegs: PEGS, bins: { y, edges: [], multipliers: [] } });
}

test("golden poses are drawn", () => {
  let compared = 0;
  for (const { name, paths, drawn } of messages) {
    for (const { ball, at, drag, pose } of drawn) {
      const path = pathOf(paths.find((each) => each.ball === ball), drag);
      const [{ x, y, theta }] = path.states([at]);
      for (const [i, value] of [x, y, theta].entries()) near(value, pose[i], 1e-9, name);
      compared += 1;
    }
  }
  assert.ok(compared > 30);
});

test("velocities are those of the drawn place", () => {
  const [, { paths: [, roll] }] = messages;
  const path = pathOf(roll, 0.5);
  const h = 1e-5;
  for (const t of [0.3, 0.9, 1.3, 1.8]) {
    const [before, now, after] = path.states([t - h, t, t + h]);
    near(now.vx, (after.x - before.x) / (2 * h), 1e-5);
    near(now.vy, (after.y - before.y) / (2 * h), 1e-5);
    near(now.omega, (after.theta - before.theta) / (2 * h), 1e-5);
  }
});

test("a path lists bounces off pegs and walls, and its landing", () => {
  const [{ paths: [fall] }, { paths: [, roll] }] = messages;
  const kinds = (path) => path.impacts.map(([, , , , , , kind, index]) => [kind, index]);
  assert.deepEqual(kinds(pathOf(fall, 0, 1.75)), [[PEG, 17], [LANDING, 0]]);
  assert.deepEqual(kinds(pathOf(roll)), [[WALL, 3], [LANDING, 0]]);
  assert.ok(!kinds(pathOf(fall, 0, 2)).some(([kind]) => kind === LANDING), "it ends above the bins");
  const path = pathOf(roll);
  const [hit, end] = path.before();
  assert.deepEqual([hit.t, end.t], [0.75, 2]);
  assert.notEqual(hit.vy, path.impacts[0][4], "it turns there");
  assert.equal(path.duration, 2);
});

test("parts of a path are joined in either order", () => {
  const [, { paths: [, { knots }] }] = messages;
  const whole = knotsOf(knots);
  const [early, late] = [whole.slice(0, 3 * KNOT), whole.slice(2 * KNOT)];
  assert.deepEqual(joined(early, late), whole);
  assert.deepEqual(joined(late, early), whole);
});
