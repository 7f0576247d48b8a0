"""A bot for a stream: for each `!drop` in the chat it drops a ball with the viewer's name.

    python stream_bot.py --room ROOM                          lines from standard input
    python stream_bot.py --room ROOM --chat ws://HOST:PORT    messages of a chat's WebSocket
    python stream_bot.py --room ROOM --chat wss://irc-ws.chat.twitch.tv --channel NAME

A line is `!drop NAME`, `viewer: !drop`, or an IRC message as Twitch's chat sends it. The bot prints
its answers. `--server` is the address of the game. If the room is yours, put its token into the
environment as PLINKO_TOKEN. Show `stage.html?room=ROOM` in your streaming software.
"""
# pip install httpx websockets

import argparse
import asyncio
import os
import re
import sys
import uuid

import httpx
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

LINES = (
    re.compile(r"!drop (?P<name>.+)"),
    re.compile(r"(?P<name>[^:]+): !drop"),
    re.compile(r"(?:@\S+ )?:(?P<name>[^!\s]+)!\S+ PRIVMSG #\S+ :!drop"),
)
AT_ONCE = 20  # requests at the same time; further viewers wait


def viewer(line):
    """The name of the viewer whose ball this line of the chat requests, or None."""
    found = (form.fullmatch(line.strip()) for form in LINES)
    return next((each["name"].strip() for each in found if each), None)


async def lines_of_input():
    while line := await asyncio.to_thread(sys.stdin.readline):
        yield line


async def lines_of_chat(address, channel):
    """Lines of a chat; reconnects whenever the connection breaks."""
    async for chat in connect(address):
        try:
            if channel:  # Twitch: reading needs no account
                await chat.send("NICK justinfan4242")
                await chat.send(f"JOIN #{channel}")
            async for message in chat:
                for line in message.splitlines():
                    if line.startswith("PING"):
                        await chat.send(line.replace("PING", "PONG", 1))
                    yield line
        except ConnectionClosed:
            continue
        if not channel:
            return  # the chat has closed the connection normally


async def drop(game, address, name):
    """Drop a ball and print where it landed."""
    # With the same key, a repeated request is still one drop, even if the first answer was lost.
    key = {"idempotency-key": str(uuid.uuid4())}
    while True:
        try:
            answer = await game.post(address, json={"name": name}, headers=key)
        except httpx.TransportError:
            await asyncio.sleep(1.0)
            continue
        if answer.status_code == 202:
            continue  # the ball is still falling: ask again for the result
        if answer.status_code not in (429, 503):
            break
        await asyncio.sleep(float(answer.headers.get("retry-after", 1.0)))
    reply = answer.json()
    if answer.is_error:
        print(f"@{name} not now: {reply['detail']}", flush=True)
        return
    landed = reply["landed"]
    won = landed.get("label") or f"{landed['score']:g}x"
    print(f"@{name} bin {landed['bin']}: {won} (seed {landed['seed']})", flush=True)


async def main():
    options = argparse.ArgumentParser(usage=__doc__)
    options.add_argument("--server", default="http://127.0.0.1:8000")
    options.add_argument("--room", default="main")
    options.add_argument("--chat")
    options.add_argument("--channel", default="")
    given = options.parse_args()
    lines = lines_of_chat(given.chat, given.channel) if given.chat else lines_of_input()
    token = os.environ.get("PLINKO_TOKEN")
    headers = {"authorization": f"Bearer {token}"} if token else {}
    address = f"{given.server.rstrip('/')}/api/v1/rooms/{given.room}/drops?wait=1"
    turns = asyncio.Semaphore(AT_ONCE)
    async with (
        httpx.AsyncClient(headers=headers, timeout=60.0) as game,
        asyncio.TaskGroup() as balls,
    ):

        async def take_turn(name):
            async with turns:
                await drop(game, address, name)

        async for line in lines:
            if name := viewer(line):
                balls.create_task(take_turn(name))


if __name__ == "__main__":
    asyncio.run(main())
