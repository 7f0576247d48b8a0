"""Drop a ball, follow it in all three streams: python websocket_client.py [ws://127.0.0.1:8000]"""
# pip install websockets plinko-server. docs/protocol.md has every message and every byte.

import json
import struct
import sys

from websockets.sync.client import connect

import plinko

SERVER = (sys.argv[1:] or ["ws://127.0.0.1:8000"])[0].rstrip("/")


def events(socket, frames):
    """Each event, in order; binary messages, which say where the balls are, go into `frames`."""
    for message in socket:
        if isinstance(message, bytes):
            frames.append(message)
        else:
            told = json.loads(message)
            yield from told if isinstance(told, list) else [told]


for stream in ("snapshots", "segments", "seeds"):
    with connect(f"{SERVER}/ws/rooms/main?stream={stream}") as connection:
        frames = []
        told = events(connection, frames)
        hello = next(told)
        connection.send(json.dumps({"type": "drop", "ref": "mine"}))
        mine = next(event for event in told if event.get("ref") == "mine")
        if mine["type"] == "error":
            sys.exit(mine["detail"])
        landed = next(e for e in told if e["type"] == "landed" and e["ball"] == mine["ball"])
        print(f"{stream}: {len(frames)} binary messages, then {landed}")
        if stream == "snapshots":  # x of the ball, from 0 at the left of the box `extent` to 1
            balls = struct.iter_unpack("<6H", b"".join(frame[12:] for frame in frames))
            print([x / 65535 for ball, x, *_ in balls if ball == mine["ball"] % 65536])
        if stream == "seeds":  # no paths are sent: the client computes them
            print(plinko.drop(plinko.Board.from_json(hello["board"]), mine["seed"]).digest)
