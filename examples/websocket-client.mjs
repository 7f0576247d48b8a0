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

/** Adds the knots of each path in a message, [t, x, y, angle, ax, ay, hit], in the order of time. */
function addPaths(frame, paths) {
  const view = new DataView(frame);
  for (let at = 0; at < frame.byteLength;) {
    const [count, ball] = [view.getUint32(at + 4, true), Number(view.getBigUint64(at + 8, true))];
    const all = new Float32Array(frame, at + 16, 7 * count);
    const knots = Array.from({ length: count }, (_, i) => all.subarray(7 * i, 7 * i + 7));
    paths.set(ball, [...(paths.get(ball) ?? []), ...knots].sort((a, b) => a[0] - b[0]));
    at += 16 + 28 * count;
  }
}

/** x and y of a ball in metres, t seconds after its start. */
function place(knots, t, drag) {
  const i = Math.max(0, knots.slice(0, -1).findLastIndex((knot) => knot[0] <= t));
  const [[t0, x0, y0, , ax, ay], [t1, x1, y1]] = [knots[i], knots[i + 1]];
  const [[phi, psi], [phi1, psi1]] = [basis(drag, t - t0), basis(drag, t1 - t0)];
  const [u, w] = [phi / phi1, psi - (psi1 * phi) / phi1];
  return { x: x0 + (x1 - x0) * u + ax * w, y: y0 + (y1 - y0) * u + ay * w };
}

/** The integral of exp(-drag s), and its integral. */
function basis(drag, s) {
  if (drag * s < 1e-6) return [s, (s * s) / 2];
  const phi = -Math.expm1(-drag * s) / drag;
  return [phi, (s - phi) / drag];
}

function follow(stream) {
  return new Promise((resolve, reject) => {
    const socket = new WebSocket(`${server}/ws/rooms/main?protocol=2&stream=${stream}`);
    socket.binaryType = "arraybuffer";
    const paths = new Map();
    let hello, mine, last = "nothing";
    socket.onopen = () => socket.send(JSON.stringify({ type: "drop", ref: "mine" }));
    socket.onmessage = ({ data }) => {
      const binary = typeof data !== "string";
      if (binary && stream === "snapshots") last = places(data, hello.extent);
      if (binary && stream === "paths") addPaths(data, paths);
      for (const event of binary ? [] : [JSON.parse(data)].flat()) {
        if (event.type === "hello") hello = event;
        if (event.type === "error") reject(new Error(event.detail));
        if (event.type === "accepted" && event.ref === "mine") mine = event.ball;
        if (event.type !== "landed" || event.ball !== mine) continue;
        if (stream === "paths") last = place(paths.get(mine), event.t, hello.board.drag);
        console.log(`${stream}: ${JSON.stringify(event)}, last seen:`, last);
        socket.close();
        resolve();
      }
    };
    socket.onerror = () => reject(new Error(`no server at ${server}`));
  });
}

for (const stream of ["snapshots", "paths", "seeds"]) await follow(stream);
