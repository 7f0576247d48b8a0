// Drop a ball and follow it in each of the three streams, in a browser or by
// node websocket-client.mjs [ws://127.0.0.1:8000] with Node.js 22 (20: --experimental-websocket).
// docs/protocol.md describes every byte. The stream `seeds` has no paths: docs/solver.md says how
// to compute them.

const server = (globalThis.process?.argv[2] ?? "ws://127.0.0.1:8000").replace(/\/$/, "");

/** The number and the position in metres of each ball in a snapshot. */
function places(frame, { x_min, x_max, y_min, y_max }) {
  const view = new DataView(frame);
  return Array.from({ length: view.getUint16(2, true) }, (_, i) => ({
    ball: view.getUint16(12 + 12 * i, true),
    x: (view.getUint16(14 + 12 * i, true) / 65535) * (x_max - x_min) + x_min,
    y: (view.getUint16(16 + 12 * i, true) / 65535) * (y_max - y_min) + y_min,
  }));
}

function follow(stream) {
  return new Promise((resolve, reject) => {
    const socket = new WebSocket(`${server}/ws/rooms/main?stream=${stream}`);
    socket.binaryType = "arraybuffer";
    let extent, mine, last = "nothing";
    socket.onopen = () => socket.send(JSON.stringify({ type: "drop", ref: "mine" }));
    socket.onmessage = ({ data }) => {
      const binary = typeof data !== "string";
      if (binary) last = stream === "snapshots" ? places(data, extent) : data;
      for (const event of binary ? [] : [JSON.parse(data)].flat()) {
        if (event.type === "hello") extent = event.extent;
        if (event.type === "error") reject(new Error(event.detail));
        if (event.type === "accepted" && event.ref === "mine") mine = event.ball;
        if (event.type !== "landed" || event.ball !== mine) continue;
        console.log(`${stream}: ${JSON.stringify(event)}, last seen:`, last);
        socket.close();
        resolve();
      }
    };
    socket.onerror = () => reject(new Error(`no server at ${server}`));
  });
}

for (const stream of ["snapshots", "segments", "seeds"]) await follow(stream);
