"""Drop a ball and follow it in each stream: python websocket_client.py [ws://127.0.0.1:8000]"""
# pip install websockets plinko-sim. docs/protocol.md describes every message and every byte.

import bisect
import json
import math
import struct
import sys

from websockets.sync.client import connect

import plinko

SERVER = (sys.argv[1:] or ["ws://127.0.0.1:8000"])[0].rstrip("/")


def events(socket, frames):
    """Yield each event in order; append binary messages, with balls' positions, to `frames`."""
    for message in socket:
        if isinstance(message, bytes):
            frames.append(message)
        else:
            received = json.loads(message)
            yield from received if isinstance(received, list) else [received]


def paths(frames):
    """The knots of each ball's path, (t, x, y, angle, ax, ay, hit), in the order of time."""
    found, data = {}, b"".join(frames)
    while data:
        _, _, _, count, ball = struct.unpack_from("<BBHIQ", data)
        knots = list(struct.iter_unpack("<7f", data[16 : 16 + 28 * count]))
        found[ball] = sorted({*found.get(ball, ()), *knots})
        data = data[16 + 28 * count :]
    return found


def place(knots, t, drag):
    """x and y of a ball in m, t seconds after its start."""
    i = min(max(bisect.bisect(knots, (t, math.inf)), 1), len(knots) - 1)
    (t0, x0, y0, _, ax, ay, _), (t1, x1, y1, *_) = knots[i - 1], knots[i]
    (phi, psi), (phi1, psi1) = basis(drag, t - t0), basis(drag, t1 - t0)
    u = phi / phi1
    return x0 + (x1 - x0) * u + ax * (psi - psi1 * u), y0 + (y1 - y0) * u + ay * (psi - psi1 * u)


def basis(drag, s):
    """The integral of exp(-drag s), and its integral."""
    phi = -math.expm1(-drag * s) / drag if drag * s > 1e-6 else s
    return phi, (s - phi) / drag if drag * s > 1e-6 else s * s / 2


for stream in ("snapshots", "paths", "seeds"):
    with connect(f"{SERVER}/ws/rooms/main?protocol=2&stream={stream}") as connection:
        frames = []
        received = events(connection, frames)
        hello = next(received)
        connection.send(json.dumps({"type": "drop", "ref": "mine"}))
        mine = next(event for event in received if event.get("ref") == "mine")
        if mine["type"] == "error":
            sys.exit(mine["detail"])
        landed = next(e for e in received if e["type"] == "landed" and e["ball"] == mine["ball"])
        print(f"{stream}: {len(frames)} binary messages, then {landed}")
        if stream == "snapshots":  # x: 0 at the left of the box `extent`, 1 at the right
            balls = struct.iter_unpack("<6H", b"".join(frame[12:] for frame in frames))
            print([x / 65535 for ball, x, *_ in balls if ball == mine["ball"] % 65536])
        if stream == "paths":  # where the ball is at any time, here every tenth of a second
            knots = paths(frames)[mine["ball"]]
            times = [i / 10 for i in range(int(10 * landed["t"]) + 1)]
            print([place(knots, t, hello["board"]["drag"]) for t in times])
        if stream == "seeds":  # the server sends no paths: the client computes them
            print(plinko.drop(plinko.Board.from_json(hello["board"]), mine["seed"]).digest)
