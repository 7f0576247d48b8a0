// Replay, verify and play over REST, in Node.js or a browser's console.
//
//     node rest-client.mjs [http://127.0.0.1:8000]

const server = (globalThis.process?.argv[2] ?? "http://127.0.0.1:8000").replace(/\/$/, "");

/** Send a request and return the JSON of the answer; throws the server's error if any. */
async function ask(method, path, body) {
  const answer = await fetch(`${server}/api/v1/${path}`, {
    method,
    headers: { "content-type": "application/json" },
    body: body && JSON.stringify(body),
  });
  const value = await answer.json();
  if (!answer.ok) throw new Error(`${value.status} ${value.code}: ${value.detail}`);
  return value;
}

// A drop is a value: the same board and seed give the same digest everywhere.
const record = await ask("GET", "drops/triangle-16/42");
console.log(`seed 42 lands in bin ${record.bin} and pays ${record.score}`);
console.log("reproduced:", (await ask("POST", "verify", record)).ok);

// Open a room with your own board, which others can watch.
const { board } = await ask("GET", "boards/triangle-8");
const room = await ask("POST", "rooms", { board: { ...board, name: "on a heavy star", gravity: 250 } });
console.log(`room ${room.id}: watch it at ${server}/?room=${room.id}`);
const { landed } = await ask("POST", `rooms/${room.id}/drops?wait=1`, { seed: "7" });
console.log(`seed 7 landed in bin ${landed.bin} after ${landed.t.toFixed(1)} s`);
