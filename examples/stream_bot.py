"""A bot for a stream: for each `!drop` in the chat a ball falls that bears the viewer's name.

    python stream_bot.py --room ROOM                          lines from standard input
    python stream_bot.py --room ROOM --chat ws://HOST:PORT    messages of a chat's WebSocket
    python stream_bot.py --room ROOM --chat wss://irc-ws.chat.twitch.tv --channel NAME

A line is `!drop NAME`, `viewer: !drop`, or a message of IRC, which is what Twitch's chat sends. The
bot writes what to answer. `--server` says where the game is, PLINKO_TOKEN in the environment is the
token of a room of your own. Show `stage.html?room=ROOM` in your streaming software.
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
AT_ONCE = 20  # requests; viewers beyond that wait for their turn


def viewer(line):
    """Who asks for a ball in this line of the chat, or None."""
    found = (form.fullmatch(line.strip()) for form in LINES)
    return next((each["name"].strip() for each in found if each), None)


async def lines_of_input():
    """Lines of standard input, as they come."""
    while line := await asyncio.to_thread(sys.stdin.readline):
        yield line


async def lines_of_chat(address, channel):
    """Lines of a chat, which is joined again whenever its connection breaks."""
    async for chat in connect(address):
        try:
            if channel:  # of Twitch, where whoever only reads needs no account
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
            return  # it has ended in order


async def drop(game, address, name):
    """Drop a ball for somebody, and say where it landed once it has."""
    # Asked for again with the same key it is still one drop, whatever became of the answer.
    key = {"idempotency-key": str(uuid.uuid4())}
    while True:
        try:
            answer = await game.post(address, json={"name": name}, headers=key)
        except httpx.TransportError:
            await asyncio.sleep(1.0)
            continue
        if answer.status_code == 202:
            continue  # it falls for long
        if answer.status_code not in (429, 503):
            break
        await asyncio.sleep(float(answer.headers.get("retry-after", 1.0)))
    told = answer.json()
    if answer.is_error:
        print(f"@{name} not now: {told['detail']}", flush=True)
        return
    landed = told["landed"]
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
