"""Replay, verify and play over REST, with only Python's standard library.

python rest_client.py [http://127.0.0.1:8000]
"""

import json
import sys
import urllib.error
import urllib.request

SERVER = (sys.argv[1:] or ["http://127.0.0.1:8000"])[0].rstrip("/")


def ask(method, path, body=None, token=None):
    """Send a request and return the JSON of the answer; exit with the server's error if any."""
    headers = {"content-type": "application/json"}
    if token:
        headers["authorization"] = f"Bearer {token}"
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(f"{SERVER}/api/v1/{path}", data, headers, method=method)
    try:
        with urllib.request.urlopen(request) as answer:
            return json.load(answer)
    except urllib.error.HTTPError as refused:
        problem = json.load(refused)
        sys.exit(f"{problem['status']} {problem['code']}: {problem['detail']}")


# A drop is a value: the same board and seed give the same digest everywhere.
record = ask("GET", "drops/triangle-16/42")
print(f"seed 42 lands in bin {record['bin']} and pays {record['score']}")
print("reproduced:", ask("POST", "verify", record)["ok"])

# Open a room with your own board, which others can watch.
board = ask("GET", "boards/triangle-8")["board"]
board |= {"name": "on a heavy star", "gravity": 250.0}
room = ask("POST", "rooms", {"board": board})
print(f"room {room['id']}: watch it at {SERVER}/?room={room['id']}")
landed = ask("POST", f"rooms/{room['id']}/drops?wait=1", {"seed": "7"})["landed"]
print(f"seed 7 landed in bin {landed['bin']} after {landed['t']:.1f} s")
