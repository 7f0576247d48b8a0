// The visitors of a table, the owners of its balls, and the last landings.

import assert from "node:assert/strict";
import { test } from "node:test";

import { COLOURS } from "../../../../static/js/model/player/colour.js";
import { Visitors, swatchOf } from "../../../../static/js/model/table/visitors.js";

const ada = { visitor: 1, name: "Ada", colour: "#57c7ff" };
const presence = (visitors, here = visitors.length) => ({ type: "presence", here, visitors });
const ball = (visitor, mine = false) => ({ visitor, mine, seed: "7", x: 0, explicit: false, pose: {} });

test("a ball has its player's colour, also when that changes", () => {
  const visitors = new Visitors(() => {});
  const flying = ball(1);
  visitors.dye(flying);
  assert.ok(COLOURS.includes(flying.pose.colour), "a visitor who is not known yet has one too");
  visitors.hear(presence([ada]), [flying]);
  assert.equal(flying.pose.colour, "#57c7ff");
  visitors.hear(presence([{ visitor: 1, name: "Ada" }]), [flying]);
  assert.equal(flying.pose.colour, swatchOf({ visitor: 1 }));
});

test("own balls keep their colour until the player chooses one", () => {
  const visitors = new Visitors(() => {});
  const [mine, nobodys] = [ball(2, true), ball(undefined)];
  nobodys.pose.colour = "#123456";
  visitors.hear(presence([ada, { visitor: 2 }]), [mine, nobodys]);
  assert.equal(mine.pose.colour, undefined);
  assert.equal(nobodys.pose.colour, "#123456");
  visitors.hear(presence([{ visitor: 2, colour: "#ffe169" }]), [mine]);
  assert.equal(mine.pose.colour, "#ffe169");
});

test("the last landings are kept with their players' names", () => {
  let changes = 0;
  const visitors = new Visitors(() => { changes += 1; });
  visitors.hear({ ...presence([ada], 3), you: 1 });
  visitors.landed(ball(1), { bin: 3, score: 2 });
  visitors.hear(presence([{ ...ada, name: "Countess" }], 3));
  assert.deepEqual([visitors.you, visitors.here, changes], [1, 3, 3]);
  assert.equal(visitors.landings[0].owner.name, "Ada");
  visitors.landed(ball(undefined), { bin: null, score: 1 });
  assert.equal(visitors.landings[0].owner, null);
  for (let i = 0; i < 100; i += 1) visitors.landed(ball(1), { bin: 1, score: i });
  assert.equal(visitors.landings.length, 8);
  assert.equal(visitors.landings[0].score, 99);
});

test("names of visitors who left are kept, up to a limit", () => {
  const visitors = new Visitors(() => {});
  visitors.hear(presence([ada]));
  visitors.hear(presence([{ visitor: 9 }]));
  assert.equal(visitors.ownerOf(ball(1)).name, "Ada");
  for (let i = 10; i < 400; i += 1) visitors.hear(presence([{ visitor: i, name: `v${i}` }]));
  assert.deepEqual(visitors.ownerOf(ball(1)), { visitor: 1 });
  assert.equal(visitors.ownerOf(ball(399)).name, "v399");
  visitors.begin();
  assert.deepEqual(visitors.ownerOf(ball(399)), { visitor: 399 }, "after a reconnect numbers belong to other visitors");
});

test("a drop's tag takes precedence over its visitor's name", () => {
  const visitors = new Visitors(() => {});
  visitors.hear(presence([ada]));
  const tagged = { ...ball(1), tag: { name: "Ben" } };
  visitors.dye(tagged);
  assert.deepEqual([tagged.by, tagged.pose.colour], ["Ben", ada.colour]);
  const bots = { ...ball(undefined), tag: { name: "Ben" } };
  visitors.dye(bots);
  assert.equal(bots.pose.colour, swatchOf({ name: "Ben" }));
  assert.deepEqual(visitors.landed(bots, { bin: 0, score: 1 }).owner, { name: "Ben" });
});
