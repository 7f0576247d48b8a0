"""A bot for a stream: viewers write `!drop` in the chat, a ball falls for each, the bot says where.

    some-chat-client | python stream_bot.py [http://127.0.0.1:8000] [room]

It reads lines `viewer: text` from standard input, as most chat tools can print them, and writes
what to answer. Show `stage.html?room=…` in your streaming software as a browser source.
"""

import json
import sys
import threading
import urllib.error
import urllib.request

SERVER = (sys.argv[1:] or ["http://127.0.0.1:8000"])[0].rstrip("/")
ROOM = (sys.argv[2:] or ["main"])[0]


def drop(viewer):
    """Drop a ball for a viewer and say where it has landed: once it has."""
    body = json.dumps({"who": viewer}).encode()
    address = f"{SERVER}/api/v1/rooms/{ROOM}/drops?wait=1"
    request = urllib.request.Request(address, body, {"content-type": "application/json"})
    try:
        with urllib.request.urlopen(request) as answer:
            landed = json.load(answer)["landed"]
        say(f"@{viewer} bin {landed['bin']}: {landed['score']:g}x (seed {landed['seed']})")
    except urllib.error.HTTPError as refused:
        problem = json.load(refused)  # a limit, a halted table: say it, and go on
        say(f"@{viewer} not now: {problem['detail']}")


def say(text):
    print(text, flush=True)


def main():
    falling = []
    for line in sys.stdin:
        viewer, _, text = line.strip().partition(": ")
        if text == "!drop" and viewer:
            thread = threading.Thread(target=drop, args=(viewer,))
            thread.start()
            falling.append(thread)
    for thread in falling:
        thread.join()


if __name__ == "__main__":
    main()
