"""A process with a server on a shared ledger, which freezes itself at one step of a commit.

`python -m tests.app.persistence.crash.freezing URL STEP` prints that step's name and freezes
(SIGSTOP). After SIGCONT it plays on, and prints as JSON which drops its players saw accepted.
"""

import json
import os
import signal
import sys

from tests.app.persistence.ledger.stepped import Table
from tests.kit.told import Told


def play(url: str, stop: int) -> None:
    told = {"main": Told("main")}
    table = Table(url, told, holder="older")
    table.until(table.rooms.resume())
    table.until(table.rooms.seek("main"))
    table.asks("main", 1)
    table.work()
    table.tick(30)
    left = stop

    def at(step: str) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            print(step, flush=True)  # noqa: T201
            os.kill(os.getpid(), signal.SIGSTOP)

    table.database.at = at
    for seed in (2, 3, 4):
        if table.rooms.all():
            table.asks("main", seed)
        table.work()
        table.tick(30)
    if left > 0:
        print("", flush=True)  # noqa: T201
    for _ in range(20):
        table.loop.pass_time(1.0)
        table.work()
        table.tick(30)
    found = told["main"]
    said = {
        "accepted": list(found.accepted.values()),
        "landed": list(found.landed.values()),
        "refused": sorted(found.refused),
        "has": [room.id for room in table.rooms.all()],
    }
    print(json.dumps(said), flush=True)  # noqa: T201


play(sys.argv[1], int(sys.argv[2]))
