"""Drop a ball over the WebSocket and follow it, in each of the three streams.

    pip install websockets plinko-server
    python websocket_client.py [ws://127.0.0.1:8000]

docs/protocol.md has every message and every byte.
"""

import asyncio
import json
import struct
import sys

from websockets.asyncio.client import connect

import plinko

SERVER = (sys.argv[1:] or ["ws://127.0.0.1:8000"])[0].rstrip("/")


def places(frame, extent):
    """Ball number and place of each ball of a snapshot, in metres."""
    count = struct.unpack_from("<2xH", frame)[0]
    for offset in range(12, 12 + 12 * count, 12):
        ball, x, y = struct.unpack_from("<HHH", frame, offset)
        width, height = extent["x_max"] - extent["x_min"], extent["y_max"] - extent["y_min"]
        yield ball, x / 65535 * width + extent["x_min"], y / 65535 * height + extent["y_min"]


async def follow(stream, room="main"):
    """Drop a ball, tell where it is seen, and return its landing."""
    async with connect(f"{SERVER}/ws/rooms/{room}?stream={stream}") as socket:
        hello = json.loads(await socket.recv())
        await socket.send(json.dumps({"type": "drop", "ref": "mine"}))
        mine, frames, path = None, 0, None
        async for message in socket:
            if isinstance(message, bytes):  # what is lossy: where the balls are
                frames += 1
                if stream == "snapshots":
                    path = list(places(message, hello["extent"])) or path
                continue
            events = json.loads(message)
            for event in events if isinstance(events, list) else [events]:
                if event["type"] == "error":
                    raise RuntimeError(event["detail"])
                if event["type"] == "accepted" and event.get("ref") == "mine":
                    mine = event["ball"]
                    if stream == "seeds":  # no paths are sent: the client computes them
                        board = plinko.Board.from_json(hello["board"])
                        path = plinko.drop(board, event["seed"])
                elif event["type"] == "landed" and event["ball"] == mine:
                    end = path.bin if stream == "seeds" else event["bin"]
                    print(f"{stream}: ball {mine} is in bin {end}, {frames} binary messages")
                    return event
    raise RuntimeError("the connection ended before the ball landed")


if __name__ == "__main__":
    for each in ("snapshots", "segments", "seeds"):
        asyncio.run(follow(each))
