// What a page of somebody else's would do, by types that were generated from the OpenAPI document.

import createClient from "openapi-fetch";
import type { components, paths } from "./schema.js";

const client = createClient<paths>({ baseUrl: process.argv[2] ?? "" });

/** What came, or the problem that the server told. */
function given<T>(reply: { data?: T; error?: components["schemas"]["Problem"] }): T {
  if (reply.error !== undefined) throw new Error(reply.error.detail);
  if (reply.data === undefined) throw new Error("nothing came");
  return reply.data;
}

const own: components["schemas"]["BoardForm"] = JSON.parse(process.argv[3] ?? "");
const checked = given(await client.POST("/api/v1/boards/check", { body: own }));

const params = { path: { board: "triangle-8", seed: "42" } };
const drop = given(await client.GET("/api/v1/drops/{board}/{seed}", { params }));
const verdict = given(await client.POST("/api/v1/verify", { body: drop }));
const frames = given(await client.GET("/api/v1/drops/{board}/{seed}/frames", {
  params: { ...params, query: { fps: 10 } },
}));

const room = given(await client.POST("/api/v1/rooms", { body: { board: own } }));
const ball = given(await client.POST("/api/v1/rooms/{room}/drops", {
  params: { path: { room: room.id }, query: { wait: true } },
  body: { seed: "7", who: "ts" },
}));
const log = given(await client.GET("/api/v1/rooms/{room}/log", {
  params: { path: { room: room.id } },
  headers: { authorization: `Bearer ${room.token}` },
}));
const refused = await client.GET("/api/v1/boards/{board}", { params: { path: { board: "none" } } });

process.stdout.write(JSON.stringify({
  name: checked.board.name,
  digest: drop.digest,
  ok: verdict.ok,
  frames: frames.frames.length,
  seed: ball.seed,
  who: log.drops?.map((each) => each.who),
  code: refused.error?.code,
}));
