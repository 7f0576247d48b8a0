// A request ends with the reply, or with an ApiError that says why.

import assert from "node:assert/strict";
import { test } from "node:test";

import { ApiError, getJson } from "../../../static/js/net/api.js";

/** Replaces the network until the test `t` ends. */
function answer(t, reply) {
  const { document, fetch } = globalThis;
  t.after(() => Object.assign(globalThis, { document, fetch }));
  Object.assign(globalThis, { document: { baseURI: "http://localhost/" }, fetch: async () => reply });
}

/** A reply whose connection ends after the first bytes of its body. */
function cutOff(status) {
  const body = new ReadableStream({
    start(controller) {
      controller.enqueue(new TextEncoder().encode('{"detail": '));
    },
    pull(controller) {
      controller.error(new TypeError("terminated"));
    },
  });
  return new Response(body, { status, headers: { "content-type": "application/json" } });
}

for (const status of [200, 503]) {
  test(`a reply of ${status} that is cut off counts as no reply`, async (t) => {
    answer(t, cutOff(status));
    await assert.rejects(getJson("boards"), (error) => error instanceof ApiError && error.status === 0);
  });
}

test("a refusal has the server's words, its status and the field", async (t) => {
  const words = { detail: "radius is -1", field: "ball.radius" };
  answer(t, Response.json(words, { status: 422 }));
  await assert.rejects(getJson("boards"), { message: "radius is -1", status: 422, field: "ball.radius" });
});
