"""The attackers: for each kind of attack, the worst valid requests from one address."""

import contextlib
import dataclasses
import http.client
import json
import re
import socket
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from benchmarks.harness.effort import MissingError
from benchmarks.scenes.expensive_boards import hall, large

LOGGED: Final = 20_000  # drops of the room whose log is read

_TIMEOUT: Final = 30.0
_TRIES: Final = 10
_PAUSE: Final = 0.02  # s to wait after a refusal
_GONE: Final = 0.2  # s to wait after a failed connection


@dataclass(slots=True)
class Attack:
    """Requests of one kind, sent by several threads at once until it stops."""

    server: str  # the server's address, as `http://HOST:PORT`
    address: str = "127.0.0.1"  # the attack's own source address, whose budget is still unspent
    logged: str = ""  # id of the room with a long log
    answers: Counter[str] = field(default_factory=Counter)
    prices: dict[str, str] = field(default_factory=dict)
    opened: dict[str, str] = field(default_factory=dict)  # room ids, and the tokens to close them
    stopped: threading.Event = field(default_factory=threading.Event)

    def ask(self, path: str, body: Any = None) -> Any:
        """Send a request and count its outcome; returns the JSON answer to a POST.

        `body` is JSON as bytes, or a value to encode. None: the request is a GET.
        """
        data = body if body is None or isinstance(body, bytes) else json.dumps(body).encode()
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
            self.stopped.wait(_GONE)
            return None
        finally:
            peer.close()
        if answer.status < 300:
            self.answers[str(answer.status)] += 1
            told = json.loads(found) if data is not None else None
            if path == "/api/v1/rooms" and told:
                self.opened[told["id"]] = told["token"]
            return told
        problem = json.loads(found or b"{}")
        self.answers[f"{answer.status} {problem.get('code', '')}"] += 1
        if answer.status == 422:
            plain = re.sub(r"/[0-9a-f]{64}", "/BOARD", path.partition("?")[0])
            self.prices[re.sub(r"/[0-9]+\b", "/SEED", plain)] = problem["detail"]
        # Without this pause, the attack would only send more requests that cost the server little.
        self.stopped.wait(_PAUSE)
        return None

    def must(self, path: str, body: Any) -> Any:
        """Repeat `ask` until it succeeds: workers may have to compile first."""
        for _ in range(_TRIES):
            found = self.ask(path, body)
            if found is not None:
                return found
        raise MissingError(f"POST {path} did not succeed: {dict(self.answers)}")

    def close_rooms(self) -> None:
        """Close the rooms that this attack opened, if they still exist."""
        while self.opened:
            room, token = self.opened.popitem()
            peer = http.client.HTTPConnection(*self._peer, timeout=_TIMEOUT)
            with contextlib.suppress(OSError, http.client.HTTPException), contextlib.closing(peer):
                head = {"Authorization": f"Bearer {token}"}
                peer.request("DELETE", f"/api/v1/rooms/{room}", headers=head)
                peer.getresponse().read()

    @property
    def _peer(self) -> tuple[str, int]:
        host, _, port = self.server.rpartition("/")[2].partition(":")
        return host, int(port)

    def hang_up(self, path: str) -> None:
        """Send a request and disconnect without waiting for the answer."""
        host, port = self._peer
        own = (self.address, 0)
        with contextlib.suppress(OSError), socket.create_connection((host, port), 5.0, own) as peer:
            peer.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\n\r\n".encode())
            self.stopped.wait(0.05)
        self.answers["hung up"] += 1

    def half_open(self, part: bytes, most: int, pause: float) -> None:
        """Send `part` up to `most` times as headers of a request that is never completed."""
        said = 0
        own = (self.address, 0)
        try:
            with socket.create_connection(self._peer, _TIMEOUT, own) as peer:
                peer.sendall(b"GET / HTTP/1.1\r\n")
                while said < most and not self.stopped.wait(pause):
                    peer.sendall(part)
                    said += 1
        except OSError:
            self.answers["cut off"] += 1
            self.stopped.wait(_GONE)

    @contextlib.contextmanager
    def going_on(self, acts: "list[Callable[[int], None]]") -> Iterator[None]:
        """Repeat each act on its own thread until the block ends."""

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
    """Animations of the largest size: some that are refused, and the most expensive accepted."""

    def act(number: int) -> None:
        fps = 60 if number % 3 == 0 else 8
        attack.ask(f"/api/v1/drops/triangle-16/{number}.webp?width=2048&fps={fps}")

    return [act] * 8


def _expensive_board(attack: Attack) -> "list[Callable[[int], None]]":
    """Pictures, batches and records on a board where each drop has a hundred thousand events."""
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

    return [act] * 2 if rooms else []  # no rooms: the server is gone, or the quota is used up


def _sandboxes(attack: Attack) -> "list[Callable[[int], None]]":
    """Ten sandboxes with the largest number of balls."""
    scene = {"scene": "sandbox", "balls": 500, "radii": [0.05, 0.08], "substeps": 8}
    rooms = [room["id"] for _ in range(10) if (room := attack.ask("/api/v1/rooms", scene))]

    def act(number: int) -> None:
        for room in rooms:
            attack.ask(f"/api/v1/rooms/{room}")
        attack.stopped.wait(1.0)

    return [act]


def _logs(attack: Attack) -> "list[Callable[[int], None]]":
    """The log of a room with many drops, a hundred times at once."""

    def act(number: int) -> None:
        attack.ask(f"/api/v1/rooms/{attack.logged}/log")

    return [act] * 100


def _hung_up(attack: Attack) -> "list[Callable[[int], None]]":
    """Requests for pictures by clients that disconnect at once."""

    def act(number: int) -> None:
        attack.hang_up(f"/api/v1/boards/triangle-16/density.png?seed={10_000 * number}&width=2048")

    return [act] * 8


def _boards(attack: Attack) -> "list[Callable[[int], None]]":
    """Boards of five thousand pegs to check."""
    body = json.dumps(large()).encode()

    def act(number: int) -> None:
        attack.ask("/api/v1/boards/check", body)

    return [act] * 4


def _registered(attack: Attack) -> "list[Callable[[int], None]]":
    """Boards of five thousand pegs to register, all different."""
    form = large()

    def begin(first: int) -> "Callable[[int], None]":
        return lambda n: attack.ask("/api/v1/boards", {**form, "name": f"board {first + 4 * n}"})

    return [begin(first) for first in range(4)]


def _large_rooms(attack: Attack) -> "list[Callable[[int], None]]":
    """Rooms over different boards of five thousand pegs."""
    form = large()

    def begin(first: int) -> "Callable[[int], None]":
        def act(number: int) -> None:
            board = {**form, "name": f"room {first + 4 * number}"}
            attack.ask("/api/v1/rooms", {"board": board})

        return act

    return [begin(first) for first in range(4)]


def _streams(attack: Attack) -> "list[Callable[[int], None]]":
    """Live pictures of `main` in the largest sizes."""

    def act(number: int) -> None:
        attack.ask(f"/api/v1/rooms/main/frame.png?width={2048 - number % 8}")

    return [act] * 4


def _half_open(attack: Attack) -> "list[Callable[[int], None]]":
    """Two hundred connections that never complete a request."""

    def act(number: int) -> None:
        attack.half_open(b"X", 1 << 20, 1.0)

    return [act] * 200


def _headers(attack: Attack) -> "list[Callable[[int], None]]":
    """Requests whose headers never end."""
    part = b"".join(b"X-%d: %s\r\n" % (number, b"x" * 1000) for number in range(64))

    def act(number: int) -> None:
        attack.half_open(part, 1 << 13, 0.0)

    return [act] * 4


def _evictions(attack: Attack) -> "list[Callable[[int], None]]":
    """Twenty-one addresses that open as many rooms as they can."""
    newcomers = [dataclasses.replace(attack, address=f"127.0.1.{n}") for n in range(1, 22)]

    def act(number: int) -> None:
        newcomers[number % len(newcomers)].ask("/api/v1/rooms", {"board": "triangle-8"})

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
    "such boards registered": _registered,
    "rooms of such boards": _large_rooms,
    "single frames of 2,048 px": _streams,
    "200 half-open connections": _half_open,
    "headers without end": _headers,
    "rooms for 21 addresses": _evictions,
}
