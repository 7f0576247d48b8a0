"""The worst valid requests of every kind from one address, and what the others notice of it."""

import asyncio
import contextlib
import http.client
import json
import re
import socket
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table
from benchmarks.serving.process import Served, can_watch, serving

SECONDS: Final = 10.0  # that an attack of one kind lasts
LATE: Final = 0.004  # s; a tick that comes later than this is a late one
LOGGED: Final = 20_000  # drops of the room whose log is read

_TIMEOUT: Final = 30.0
_TRIES: Final = 10
_SETTLES: Final = 1.0  # s after which a room that slept runs, and the player's clock is set
_UNBOUND: Final = ("--drop-rate", "100000", "--message-rate", "100000")
"""So that a room gets a long log soon; the attacks have nothing of it that computes."""


def hall(gravity: float = 10_000.0) -> dict[str, Any]:
    """A board whose balls bounce up to a hundred thousand times before they find the way out."""
    smooth = {"restitution": 1.0, "friction": 0.0}
    walls = [(-0.5, -0.25, -0.5, 0.75), (0.5, -0.25, 0.5, 0.75), (-0.5, -0.25, 0.5, -0.25),
             (-0.5, 0.225, -0.012501, 0.25), (0.012501, 0.25, 0.5, 0.225)]  # fmt: skip
    return {
        "name": "hall",
        "width": 1.0,
        "height": 0.75,
        "gravity": gravity,
        "ball": {"radius": 0.0125, "density": 1.0, **smooth},
        "peg_material": smooth,
        "wall_material": smooth,
        "pegs": [],
        "walls": [dict(zip(("x1", "y1", "x2", "y2"), wall, strict=True)) for wall in walls],
        "bins": {"y": 0.75, "edges": [-0.5, 0.0, 0.5], "multipliers": [1.0, 2.0]},
        "drop": {"x": 0.25, "y": -0.125, "jitter": 0.125},
    }


@dataclass(slots=True)
class Attack:
    """Requests of one kind, sent by several threads at once until it stops."""

    server: Served
    address: str = "127.0.0.1"  # of its own: what others had computed is not charged to it
    logged: str = ""  # the room whose log is long
    answers: Counter[str] = field(default_factory=Counter)
    prices: dict[str, str] = field(default_factory=dict)
    stopped: threading.Event = field(default_factory=threading.Event)

    def ask(self, path: str, body: Any = None) -> Any:
        """Send a request; counts what came of it, and returns a JSON answer to a POST."""
        data = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json"} if data else {}
        peer = http.client.HTTPConnection(
            *self._peer, timeout=_TIMEOUT, source_address=(self.address, 0)
        )
        try:
            peer.request("GET" if data is None else "POST", path, data, headers)
            answer = peer.getresponse()
            found = answer.read()
        except (OSError, http.client.HTTPException) as error:
            self.answers[type(error).__name__] += 1
            return None
        finally:
            peer.close()
        if answer.status < 300:
            self.answers[str(answer.status)] += 1
            return json.loads(found) if data is not None else None
        problem = json.loads(found or b"{}")
        self.answers[f"{answer.status} {problem.get('code', '')}"] += 1
        if answer.status == 422:
            plain = re.sub(r"/[0-9a-f]{64}", "/BOARD", path.partition("?")[0])
            self.prices[re.sub(r"/[0-9]+\b", "/SEED", plain)] = problem["detail"]
        # A client that is told to wait and does not is one more request, no more work.
        self.stopped.wait(0.02)
        return None

    def must(self, path: str, body: Any) -> Any:
        """`ask` until there is an answer: workers may have to compile first."""
        for _ in range(_TRIES):
            found = self.ask(path, body)
            if found is not None:
                return found
        raise MissingError(f"POST {path} was not answered: {dict(self.answers)}")

    @property
    def _peer(self) -> tuple[str, int]:
        host, _, port = self.server.address.rpartition("/")[2].partition(":")
        return host, int(port)

    def hang_up(self, path: str) -> None:
        """Ask for something and leave at once."""
        host, port = self._peer
        own = (self.address, 0)
        with contextlib.suppress(OSError), socket.create_connection((host, port), 5.0, own) as peer:
            peer.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\n\r\n".encode())
            self.stopped.wait(0.05)
        self.answers["hung up"] += 1

    @contextlib.contextmanager
    def going_on(self, acts: "list[Callable[[int], None]]") -> Iterator[None]:
        """Each act over and over, on a thread of its own, until the block ends."""

        def again(act: Callable[[int], None]) -> None:
            number = 0
            while not self.stopped.is_set():
                act(number)
                number += 1

        threads = [threading.Thread(target=again, args=(act,)) for act in acts]
        for thread in threads:
            thread.start()
        try:
            yield
        finally:
            self.stopped.set()
            for thread in threads:
                thread.join()


def _nothing(attack: Attack) -> "list[Callable[[int], None]]":
    return []


def _pictures(attack: Attack) -> "list[Callable[[int], None]]":
    """Animations of the largest size: refused ones, and the dearest that are taken."""

    def act(number: int) -> None:
        fps = 60 if number % 3 == 0 else 8
        attack.ask(f"/api/v1/drops/triangle-16/{number}.webp?width=2048&fps={fps}")

    return [act] * 8


def _expensive_board(attack: Attack) -> "list[Callable[[int], None]]":
    """Pictures, tallies and records of a board whose every drop takes a hundred thousand events."""
    digest = attack.must("/api/v1/boards", hall())["digest"]

    def act(number: int) -> None:
        seed = 10_000 * number
        attack.ask(f"/api/v1/boards/{digest}/density.png?drops=10000&width=2048&seed={seed}")
        attack.ask("/api/v1/simulate", {"board": digest, "drops": 10_000, "seed": str(seed)})
        attack.ask(f"/api/v1/drops/{digest}/{number}.webp?width=2048&fps=60")
        attack.ask(f"/api/v1/drops/{digest}/{number}/frames?fps=90")

    return [act] * 4


def _stepped(attack: Attack) -> "list[Callable[[int], None]]":
    """Stepped drops with the shortest steps."""
    digest = attack.must("/api/v1/boards", hall(9.81))["digest"]

    def act(number: int) -> None:
        for board in (digest, "triangle-16"):
            attack.ask(f"/api/v1/drops/{board}/{number}?solver=stepped&dt=0.0001&substeps=1")
        body = {"board": "triangle-16", "drops": 10_000, "solver": "stepped", "dt": 1e-4}
        attack.ask("/api/v1/simulate", {**body, "substeps": 1})

    return [act] * 4


def _rooms(attack: Attack) -> "list[Callable[[int], None]]":
    """Rooms of the expensive board with forty drops each."""
    rooms = [room for _ in range(5) if (room := attack.ask("/api/v1/rooms", {"board": hall()}))]

    def act(number: int) -> None:
        room = rooms[number % len(rooms)]
        attack.ask(f"/api/v1/rooms/{room['id']}/drops", {})

    return [act] * 2


def _sandboxes(attack: Attack) -> "list[Callable[[int], None]]":
    """Ten sandboxes of as many balls as there may be."""
    scene = {"scene": "sandbox", "balls": 500, "radii": [0.05, 0.08], "substeps": 8}
    rooms = [room["id"] for _ in range(10) if (room := attack.ask("/api/v1/rooms", scene))]

    def act(number: int) -> None:
        for room in rooms:
            attack.ask(f"/api/v1/rooms/{room}")
        attack.stopped.wait(1.0)

    return [act]


def _logs(attack: Attack) -> "list[Callable[[int], None]]":
    """The log of a room of many drops, a hundred times at once."""

    def act(number: int) -> None:
        attack.ask(f"/api/v1/rooms/{attack.logged}/log")

    return [act] * 100


def _hung_up(attack: Attack) -> "list[Callable[[int], None]]":
    """Pictures that are asked for and not waited for."""

    def act(number: int) -> None:
        attack.hang_up(f"/api/v1/boards/triangle-16/density.png?seed={10_000 * number}&width=2048")

    return [act] * 8


def _boards(attack: Attack) -> "list[Callable[[int], None]]":
    """Boards of five thousand pegs to be checked."""
    pegs = [
        {"x": -20 + 0.4 * (n % 100) + 0.2 * (n // 100 % 2), "y": 0.4 * (n // 100), "radius": 0.05}
        for n in range(4_900)
    ]
    form = {**hall(9.81), "name": "large", "width": 44.0, "height": 21.0}
    form |= {
        "ball": {"radius": 0.05},
        "pegs": pegs,
        "bins": {"y": 21.0, "edges": [-22, 0, 22], "multipliers": [1, 2]},
    }
    form["walls"] = [{"x1": x, "y1": -2, "x2": x, "y2": 21} for x in (-22, 22)]

    def act(number: int) -> None:
        attack.ask("/api/v1/boards/check", {**form, "drop": {"x": 0.1, "y": -0.7, "jitter": 0.1}})

    return [act] * 4


def _streams(attack: Attack) -> "list[Callable[[int], None]]":
    """Live pictures in the largest size, of rooms that move."""

    def act(number: int) -> None:
        attack.ask(f"/api/v1/rooms/main/frame.png?width={2048 - number % 8}")

    return [act] * 4


KINDS: Final[dict[str, "Callable[[Attack], list[Callable[[int], None]]]"]] = {
    "nothing": _nothing,
    "pictures of 2,048 px": _pictures,
    "a board of 100,000 bounces": _expensive_board,
    "stepped drops at 0.1 ms": _stepped,
    "rooms of that board": _rooms,
    "ten sandboxes of 500": _sandboxes,
    f"100 logs of {LOGGED:,} drops": _logs,
    "asked and hung up": _hung_up,
    "boards of 5,000 pegs": _boards,
    "single frames of 2,048 px": _streams,
}


class Player:
    """A player of `main`: when its snapshots come, and how long its drops wait.

    `clock` estimates when each tick was due; see app.load.client.
    """

    def __init__(self, clock: Any) -> None:
        self.late: list[float] = []
        self.accepted: list[float] = []
        self.refused = 0
        self.asked: dict[str, float] = {}
        self._clock = clock
        self._settled = float("inf")  # from when on the room has not slept

    def event(self, client: Any, event: dict[str, Any], now: float) -> None:
        """Take an event: a pong sets the clock, an acceptance ends a wait."""
        if event["type"] == "pong":
            self._clock.observe(event, now)
        elif event["type"] == "accepted" and event.get("ref") in self.asked:
            self.accepted.append(now - self.asked.pop(event["ref"]))
        elif event["type"] == "error":
            self.refused += 1

    def binary(self, client: Any, data: bytes, now: float) -> None:
        """Take a snapshot: it is due when its tick is."""
        tick = int.from_bytes(data[4:8], "little")
        if self._clock.known and now > self._settled:
            self.late.append(now - self._clock.due(tick))

    def closed(self, client: Any, code: int, reason: str) -> None:
        """Nothing: what does not come is missed."""

    async def play(self, address: str, seconds: float) -> None:
        """Drop a ball four times a second, so that the room never sleeps."""
        from app.load.client import connect, room_url

        client = await connect(room_url(address, "main", "snapshots"), self)
        self._settled = time.monotonic() + _SETTLES
        end = self._settled + seconds
        number = 0
        while (now := time.monotonic()) < end:
            client.send(type="ping", t=now)
            self.asked[str(number)] = now
            client.send(type="drop", ref=str(number))
            number += 1
            await asyncio.sleep(0.25)
        client.close()


def memory(server: Served) -> float:
    """Bytes of the server and of all its workers, shared ones counted once."""
    found = 0.0
    for pid in _family(server.process.pid):
        with contextlib.suppress(OSError):
            for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
                if line.startswith("Pss:"):
                    found += 1024.0 * float(line.split()[1])
    return found


def _family(pid: int) -> list[int]:
    found = [pid]
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += _family(int(child))
    return found


def run(effort: Effort) -> Section:
    """One attack after the other on a server with its own limits, then all of them together."""
    if not can_watch():
        raise MissingError("the system does not tell the memory of processes")
    section = Section("attack")
    seconds = float(effort.size(int(SECONDS), 2))
    rows = []
    refusals: dict[str, str] = {}
    with serving(_UNBOUND) as server:
        logged = _room_with_log(server, effort.size(LOGGED, 50))
        kinds = [*KINDS.items(), ("all of these at once", _all)]
        for number, (name, kind) in enumerate(kinds, 2):
            effort.step(name)
            found = _suffer(Attack(server, f"127.0.0.{number}", logged), kind, seconds)
            section.data[name] = found
            refusals |= found["prices"]
            rows.append(_row(name, found))
    section.tables.append(_table(rows, seconds))
    section.tables.append(
        Table(
            "What was refused for its price",
            ["request", "why"],
            [[path, why] for path, why in refusals.items()],
        )
    )
    return section


def _all(attack: Attack) -> "list[Callable[[int], None]]":
    return [act for kind in KINDS.values() for act in kind(attack)[:4]]


def _room_with_log(server: Served, drops: int) -> str:
    """A room with so many drops in its log: their balls land at once."""
    fast = {**hall(), "name": "fast", "walls": hall()["walls"][:2]}
    room: str = Attack(server).must("/api/v1/rooms", {"board": fast})["id"]

    async def fill() -> None:
        from app.load.client import Clock, connect, room_url

        player = Player(Clock(60.0))
        client = await connect(room_url(server.address, room, "snapshots"), player)
        for number in range(drops):
            while number - len(player.accepted) > 20:
                await asyncio.sleep(0.002)
            player.asked[str(number)] = time.monotonic()
            client.send(type="drop", seed=number, ref=str(number))
        client.close()

    asyncio.run(fill())
    return room


def _suffer(
    attack: Attack, kind: "Callable[[Attack], list[Callable[[int], None]]]", seconds: float
) -> dict[str, Any]:
    from app.load.client import Clock

    server, player = attack.server, Player(Clock(60.0))
    most = 0.0
    with attack.going_on(kind(attack)):
        watching = threading.Thread(
            target=lambda: asyncio.run(player.play(server.address, seconds))
        )
        watching.start()
        while watching.is_alive():
            most = max(most, memory(server))
            watching.join(0.5)
    late = sorted(player.late)
    waits = sorted(player.accepted)
    return {
        "ticks_per_second": len(late) / seconds,
        "within_4_ms": sum(each <= LATE for each in late) / max(len(late), 1),
        "late_99": late[int(0.99 * len(late))] if late else float("nan"),
        "accepted_99": waits[int(0.99 * len(waits))] if waits else float("nan"),
        "refused": player.refused,
        "memory": most,
        "answers": dict(attack.answers),
        "prices": dict(attack.prices),
    }


def _row(name: str, found: dict[str, Any]) -> list[str]:
    answers = ", ".join(f"{count} x {code}" for code, count in sorted(found["answers"].items()))
    return [
        name,
        f"{found['ticks_per_second']:.1f}",
        f"{100 * found['within_4_ms']:.1f} %",
        f"{1e3 * found['late_99']:.1f}",
        f"{1e3 * found['accepted_99']:.0f}",
        f"{found['memory'] / 1e6:,.0f}",
        answers or "-",
    ]


def _table(rows: list[list[str]], seconds: float) -> Table:
    return Table(
        "`main` while one address sends the worst valid requests",
        ["attack", "ticks a second", "within 4 ms", "99 % within, ms",
         "drops accepted (99 %), ms", "memory, MB", "answers"],
        rows,
        [
            f"For {seconds:g} s each, on a server with its default limits; a player of `main` "
            "drops four balls a second and notes when each snapshot comes after its tick was due. "
            "The attackers and the player share the machine with the server. Memory: of the "
            "server and its workers, what they share counted once. Aims: 60 ticks a second, 99 % "
            "of them within 4 ms, drops accepted in 50 ms, less than 600 MB."
        ],
    )  # fmt: skip
