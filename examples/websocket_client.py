"""Drop a ball and follow it in each stream: python websocket_client.py [ws://127.0.0.1:8000]"""
# pip install websockets plinko-server. docs/protocol.md describes every message and every byte.

import json
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


for stream in ("snapshots", "segments", "seeds"):
    with connect(f"{SERVER}/ws/rooms/main?stream={stream}") as connection:
        frames = []
        received = events(connection, frames)
        hello = next(received)
        connection.send(json.dumps({"type": "drop", "ref": "mine"}))
        mine = next(event for event in received if event.get("ref") == "mine")
        if mine["type"] == "error":
            sys.exit(mine["detail"])
        landed = next(e for e in received if e["type"] == "landed" and e["ball"] == mine["ball"])
        print(f"{stream}: {len(frames)} binary messages, then {landed}")
        if (
            stream == "snapshots"
        ):  # x of the ball: 0 at the left of the box `extent`, 1 at the right
            balls = struct.iter_unpack("<6H", b"".join(frame[12:] for frame in frames))
            print([x / 65535 for ball, x, *_ in balls if ball == mine["ball"] % 65536])
        if stream == "seeds":  # the server sends no paths: the client computes them
            print(plinko.drop(plinko.Board.from_json(hello["board"]), mine["seed"]).digest)
