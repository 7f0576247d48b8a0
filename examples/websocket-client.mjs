// Drop a ball over the WebSocket and follow it, in each of the three streams: in a browser, or
//
//     node websocket-client.mjs [ws://127.0.0.1:8000]
//
// with Node.js 22 (20 with --experimental-websocket). docs/protocol.md has every byte.

const server = (globalThis.process?.argv[2] ?? "ws://127.0.0.1:8000").replace(/\/$/, "");

/** Ball number and place of each ball of a snapshot, in metres. */
function places(frame, { x_min, x_max, y_min, y_max }) {
  const view = new DataView(frame);
  return Array.from({ length: view.getUint16(2, true) }, (_, i) => ({
    ball: view.getUint16(12 + 12 * i, true),
    x: (view.getUint16(14 + 12 * i, true) / 65535) * (x_max - x_min) + x_min,
    y: (view.getUint16(16 + 12 * i, true) / 65535) * (y_max - y_min) + y_min,
  }));
}

/** Drop a ball, count what is seen of it, and return its landing. */
function follow(stream, room = "main") {
  return new Promise((resolve, reject) => {
    const socket = new WebSocket(`${server}/ws/rooms/${room}?stream=${stream}`);
    socket.binaryType = "arraybuffer";
    let hello, mine, seen = 0;
    socket.onmessage = ({ data }) => {
      if (typeof data !== "string") { // what is lossy: where the balls are
        seen += stream === "snapshots" ? places(data, hello.extent).length : 1;
        return;
      }
      for (const event of [JSON.parse(data)].flat()) {
        if (event.type === "hello") {
          hello = event;
          socket.send(JSON.stringify({ type: "drop", ref: "mine" }));
        } else if (event.type === "error") {
          reject(new Error(event.detail));
        } else if (event.type === "accepted" && event.ref === "mine") {
          mine = event.ball; // in the stream `seeds`, compute the path from event.seed: docs/solver.md
        } else if (event.type === "landed" && event.ball === mine) {
          console.log(`${stream}: ball ${mine} has landed, seen ${seen} times`);
          socket.close();
          resolve(event);
        }
      }
    };
    socket.onerror = () => reject(new Error(`no server at ${server}`));
  });
}

for (const stream of ["snapshots", "segments", "seeds"]) await follow(stream);
