"""A bot for a stream: for each `!drop` in the chat it drops a ball with the viewer's name.

    python stream_bot.py --room ROOM                          lines from standard input
    python stream_bot.py --room ROOM --chat ws://HOST:PORT    messages of a chat's WebSocket
    python stream_bot.py --room ROOM --chat wss://irc-ws.chat.twitch.tv --channel NAME

A line is `!drop NAME` or `viewer: !drop`; with --channel, an IRC message as Twitch's chat sends it.
The bot prints its answers. `--server` is the address of the game. If the room is yours, put its
token into the environment as PLINKO_TOKEN. Show `stage.html?room=ROOM` in your streaming software.
"""
# pip install httpx websockets

import argparse
import asyncio
import os
import re
import sys
import time
import uuid
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime

import httpx
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

# A viewer's text must never pass for another form of line, or it could drop under any name.
LINES = (
    re.compile(r"!drop (?P<name>[^:]+)", re.IGNORECASE),
    re.compile(r"(?P<name>[^:]+): *!drop", re.IGNORECASE),
)
IRC = re.compile(r"(?:@\S+ )?:(?P<name>[^!\s]+)!\S+ PRIVMSG #\S+ :\s*!drop(?: .*)?", re.IGNORECASE)
# Invisible, though Python counts them as printable. Chat programs add such characters to a message
# that repeats the last one, as they do U+E0000, because chats refuse repetitions.
UNSEEN = re.compile("[\u034f\u115f\u1160\u2800\u3164\ufe00-\ufe0f\uffa0]")
MAX_NAME = 24  # characters that the game shows
AT_ONCE = 20  # requests at the same time; further viewers wait
BUSY = {202, 429, 500, 502, 503, 504}  # 202: the ball is still falling
PATIENCE = 300.0  # s that a viewer waits for a server that is busy or away


def viewer(line, forms=LINES):
    """The name of the viewer whose ball this line of the chat requests, or None."""
    text = "".join(each for each in UNSEEN.sub("", line) if each.isprintable())
    found = (form.fullmatch(text.strip()) for form in forms)
    return next((each["name"].strip()[:MAX_NAME].strip() for each in found if each), None)


async def lines_of_input():
    while line := await asyncio.to_thread(sys.stdin.readline):
        yield line


async def lines_of_chat(address, channel):
    """Lines of IRC, or messages of another chat; reconnects whenever the connection breaks."""
    async for chat in connect(address):
        try:
            if channel:  # Twitch: reading needs no account
                await chat.send("NICK justinfan4242")
                await chat.send(f"JOIN #{channel}")
            async for message in chat:
                text = message if isinstance(message, str) else message.decode(errors="replace")
                # A viewer's text may contain U+2028, at which `splitlines` would split.
                for line in text.split("\r\n") if channel else [text]:
                    if channel and line.startswith("PING"):
                        await chat.send(line.replace("PING", "PONG", 1).strip())
                    yield line
        except ConnectionClosed:
            continue
        if not channel:
            return  # the chat has closed the connection normally


def pause(answer):
    """Seconds until the next attempt: `Retry-After` has seconds or a date (RFC 9110)."""
    after = answer.headers.get("retry-after", "1")
    try:
        wait = float(after) if after.isdecimal() else until(parsedate_to_datetime(after))
    except (TypeError, ValueError):
        wait = 1.0
    return min(max(wait, 0.1), 60.0)


def until(date):
    return (date - datetime.now(UTC)).total_seconds()


async def drop(game, address, name):
    """Drop a ball; returns where it landed, or why it did not, in words."""
    # With the same key, a repeated request is still one drop, even if the first answer was lost.
    key = {"idempotency-key": str(uuid.uuid4())}
    end = time.monotonic() + PATIENCE
    while True:
        try:
            answer = await game.post(address, json={"name": name}, headers=key)
            wait = pause(answer) if answer.status_code in BUSY else 0.0
            why = f"the server answered {answer.status_code}"
        except httpx.HTTPError as error:
            wait, why = 1.0, str(error) or type(error).__name__
        if not wait:
            break
        if time.monotonic() + wait > end:
            return f"not now: {why}"
        await asyncio.sleep(wait)
    try:
        reply = answer.json()
        if answer.is_error:
            return f"not now: {reply['detail']}"
        landed = reply["landed"]
        won = landed.get("label") or f"{landed['score']:g}x"
        return f"bin {landed['bin']}: {won} (seed {landed['seed']})"
    except (
        LookupError,
        TypeError,
        ValueError,
        AttributeError,
    ):  # not from the game: a proxy's page
        return f"not now: {why}"


async def main():
    options = argparse.ArgumentParser(usage=__doc__)
    options.add_argument("--server", default="http://127.0.0.1:8000")
    options.add_argument("--room", default="main")
    options.add_argument("--chat")
    options.add_argument("--channel", default="")
    given = options.parse_args()
    sys.stdin.reconfigure(encoding="utf-8", errors="replace", newline="\n")
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")
    channel = given.channel.lower().removeprefix("#")
    lines = lines_of_chat(given.chat, channel) if given.chat else lines_of_input()
    forms = (IRC,) if given.chat and channel else LINES
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
                print(f"@{name} {await drop(game, address, name)}", flush=True)

        async for line in lines:
            if name := viewer(line, forms):
                balls.create_task(take_turn(name))


if __name__ == "__main__":
    asyncio.run(main())
