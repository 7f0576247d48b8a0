"""Estimates for large numbers: recorded unit costs times a number of clients, rooms or drops."""

import math
from dataclasses import dataclass
from typing import Final

from benchmarks.harness.effort import MissingError
from benchmarks.harness.recorded import FOLDER, Recorded, read, text_of
from benchmarks.harness.report import Section, Table
from benchmarks.scale import units
from benchmarks.serving import relays
from benchmarks.serving.streams import CLIENTS, FALL, IN_FLIGHT
from plinko.app.listening import MAX_CONNECTIONS
from plinko.app.settings import TICK_RATE, Settings
from plinko.engine.batches.hashes import KEPT
from plinko.engine.drops.digest import BLOCK

FILE: Final = FOLDER / "estimates.json"

SPECTATORS: Final = 1_000_000
ROOMS: Final = 100_000
DROPS: Final = 10**12

SHARE: Final = 0.5
"""Share of a core that a process spends on its rooms or on their clients; the rest is for requests
and bursts."""

DAY: Final = 86_400.0  # s
WORKERS: Final = 1000

STREAMS: Final = f"The streams of a room, {IN_FLIGHT} balls in flight"
CROWDS: Final = "One room at 60 Hz, some 50 balls in flight"
WIRE: Final = "Bytes a second of flight and ball"
MEMORY: Final = "Resident memory"
BATCHES: Final = "Batches: drops per second"

_ROW: Final = 40
"""Bytes of a drop's row before compression: seed, bin, score, duration, impacts, x_end."""

_HASH: Final = 68
"""Bytes of a hash in a result's JSON: 64 digits, quotes, comma and space."""


@dataclass(frozen=True)
class Units:
    """Measured unit costs.

    streams: by stream, clients per core, bytes/s and messages/s of one client; empty if not
    recorded. relayed: the same for the spectators of a relay and the relay's core. ticks,
    room_bytes: s of a core and bytes of a room, by its balls in flight. drop, mark: s in
    PostgreSQL; row: bytes of a drop there. client, server: resident bytes. rate: drops/s of a core.
    """

    streams: dict[str, tuple[float, float, float]]
    ticks: dict[int, float]
    room_bytes: dict[int, float]
    drop: float
    mark: float
    row: float
    client: float
    server: float
    rate: float
    relayed: tuple[float, float, float] | None = None


def units_of(page: Recorded) -> Units:
    """The recorded unit costs; raises MissingError for the first one that is not recorded.

    Only the comparison of the streams may be missing, because only a quiet machine can measure it.
    The cost of snapshots then comes from the largest crowd and from the bytes per ball on the wire.
    """

    def stream(name: str) -> tuple[float, float, float]:
        columns = ("clients a core", "bytes/s a client", "messages/s a client")
        clients, size, messages = (page.number(STREAMS, name, column) for column in columns)
        return clients, size, messages

    def ledger(column: str) -> float:
        return page.number(units.LEDGER, "PostgreSQL", column)

    crowd = max(CLIENTS["snapshots"])
    return Units(
        streams=(
            {row["stream"]: stream(row["stream"]) for row in page.rows(STREAMS)}
            if page.has(STREAMS)
            else {"snapshots": _crowd(page)}
        ),
        ticks={n: 1e-6 * page.number(units.ROOM, str(n), "µs a tick") for n in units.BALLS},
        room_bytes={n: page.number(units.ROOM, str(n), "bytes") for n in (0, *units.BALLS)},
        drop=1e-6 * ledger("µs a drop"),
        mark=1e-6 * ledger("µs a mark"),
        row=ledger("bytes a drop"),
        client=page.number(MEMORY, f"each of {crowd} clients who watch {IN_FLIGHT} balls", "bytes"),
        server=page.number(MEMORY, "the server, physics loaded, ready", "bytes"),
        rate=page.number(BATCHES, "triangle-16", "lanes, native"),
        relayed=_relayed(page) if page.has(relays.COST) else None,
    )


def _crowd(page: Recorded) -> tuple[float, float, float]:
    """Clients per core for snapshots, bytes/s and messages/s of one client."""
    clients, rate = 800, TICK_RATE
    share = page.number(CROWDS, str(clients), "of a core")
    for row in page.rows(WIRE):
        if row["board"] == units.BOARD and row["balls"] == str(IN_FLIGHT):
            return clients / share, IN_FLIGHT * float(row["snapshots"].replace(",", "")), rate
    raise MissingError(f"no file records {units.BOARD} with {IN_FLIGHT} balls under {WIRE!r}")


def _relayed(page: Recorded) -> tuple[float, float, float]:
    """Spectators per core of a relay, bytes/s and messages/s of one spectator."""
    crowd = f"{max(relays.CROWDS):,}"
    return (
        page.number(relays.COST, relays.SERVED, "value"),
        page.number(relays.SHARES, crowd, "bytes/s a spectator"),
        page.number(relays.SHARES, crowd, "messages/s a spectator"),
    )


def record() -> str:
    """The text of the file of estimates."""
    return text_of({"plots": []} | Section("estimates", tables(units_of(read()))).to_dict())


def tables(cost: Units) -> list[Table]:
    """The tables of the record `estimates`."""
    spectators = [_spectators(cost)] if cost.streams or cost.relayed else []
    return [_costs(cost), *spectators, _rooms(cost), _drops(cost), _first(cost)]


def _costs(cost: Units) -> Table:
    rows = [
        [f"clients that a core serves by {name}", f"{clients:,.0f}", "stream"]
        for name, (clients, _, _) in cost.streams.items()
    ]
    rows += [
        [f"bytes a second of a client by {name}", f"{size:,.0f}", "stream"]
        for name, (_, size, _) in cost.streams.items()
    ]
    if cost.relayed:
        served, size, _ = cost.relayed
        rows += [
            [relays.SERVED, f"{served:,.0f}", "relays"],
            ["bytes a second of one of them", f"{size:,.0f}", "relays"],
        ]
    rows += [
        ["memory of a client", _bytes(cost.client), "stream"],
        ["memory of a server that is ready", _bytes(cost.server), "stream"],
    ]
    rows += [
        [f"a tick of a room with {n} ball{'s' * (n > 1)}", _time(s), "scale"]
        for n, s in cost.ticks.items()
    ]
    rows += [
        [f"memory of a room with {n} ball{'s' * (n != 1)}", _bytes(size), "scale"]
        for n, size in cost.room_bytes.items()
    ]
    rows += [
        ["a drop with its result in PostgreSQL", _time(cost.drop), "scale"],
        ["a mark of how far a room has come", _time(cost.mark), "scale"],
        ["bytes of a drop in PostgreSQL", _bytes(cost.row), "scale"],
        ["drops that a core computes", f"{cost.rate:,.0f}/s", "lanes"],
    ]
    return Table("What little takes", ["what", "measured", "by the benchmark"], rows)


def _spectators(cost: Units) -> Table:
    rows = []
    served = dict(cost.streams) | ({"seeds, over relays": cost.relayed} if cost.relayed else {})
    for name, (clients, size, messages) in served.items():
        rows.append(
            [
                name,
                f"{SPECTATORS / clients:,.0f}",
                f"{processes_for(SPECTATORS, clients):,}",
                _bytes(SPECTATORS * cost.client),
                f"{_bytes(SPECTATORS * size)}/s",
                f"{SPECTATORS * messages:,.0f}",
            ]
        )
    most = MAX_CONNECTIONS
    return Table(
        f"{SPECTATORS:,} spectators of one room",
        ["by", "cores", "processes", "memory", "sent", "messages a second"],
        rows,
        [
            f"Extrapolated from a thousandth of the clients, in a room with {IN_FLIGHT} balls in "
            f"flight. A process gives {SHARE:.0%} of a core to its clients and has at most "
            f"{most:,} connections."
        ],
    )


def processes_for(spectators: int, clients: float) -> int:
    """Processes for `spectators`, if a core serves `clients`: limited by time and connections."""
    return math.ceil(spectators / min(SHARE * clients, MAX_CONNECTIONS))


def _rooms(cost: Units) -> Table:
    rate = TICK_RATE
    rows = [["0, all asleep", "0", _bytes(ROOMS * cost.room_bytes[0]), "0", "0", "0"]]
    for balls, tick in cost.ticks.items():
        drops = ROOMS * balls / FALL
        rows.append(
            [
                str(balls),
                f"{ROOMS * rate * tick:,.0f}",
                _bytes(ROOMS * cost.room_bytes[balls]),
                f"{drops:,.0f}",
                f"{drops * cost.drop:,.1f}",
                _bytes(drops * cost.row * DAY),
            ]
        )
    return Table(
        f"{ROOMS:,} rooms",
        [
            "balls in flight in each",
            "cores for ticks",
            "memory",
            "drops a second",
            "ledgers",
            "bytes a day",
        ],
        rows,
        [
            f"Extrapolated. {rate} ticks a second. A ball falls for {FALL:g} s, then the next one "
            "starts. Ledgers: how many committing threads, each with its own database, would be "
            "busy all the time. A process keeps 256 sleeping rooms in memory; the ledger has the "
            "others."
        ],
    )


def _drops(cost: Units) -> Table:
    seconds, blocks = DROPS / cost.rate, -(-DROPS // BLOCK)
    level = (-(-blocks // KEPT) - 1).bit_length()
    rows = [
        ["core hours", f"{seconds / 3600:,.0f}", "extrapolated"],
        [f"hours on {WORKERS:,} cores", f"{seconds / 3600 / WORKERS:,.1f}", "extrapolated"],
        ["blocks", f"{blocks:,}", "counted"],
        ["blocks a second, of all workers", f"{WORKERS * cost.rate / BLOCK:,.0f}", "extrapolated"],
        ["hashes that the result keeps", f"{-(-blocks >> level):,}", "counted"],
        ["its file", _bytes(-(-blocks >> level) * _HASH), "counted"],
        ["a part that is checked alone", f"{_time((BLOCK << level) / cost.rate)}", "extrapolated"],
        ["rows of all drops, if kept", _bytes(DROPS * _ROW), "counted, before compression"],
    ]
    return Table(f"{DROPS:.0e} drops of triangle-16".replace("+", ""), ["what", "value", ""], rows)


def _first(cost: Units) -> Table:
    """The largest numbers that one server, one ledger and one room can take."""
    rate = TICK_RATE
    ticks = SHARE / (rate * cost.ticks[1])
    rows = [
        ["rooms awake, a ball in each", "the process that ticks them", f"{ticks:,.0f}"],
        ["rooms awake, a ball in each", "the ledger", f"{FALL / cost.drop:,.0f}"],
        ["drops a second", "the ledger", f"{1.0 / cost.drop:,.0f}"],
        *(
            [f"spectators of a room by {name}", "its process", f"{SHARE * clients:,.0f}"]
            for name, (clients, _, _) in cost.streams.items()
        ),
        ["spectators of a room", "`--max-clients`", f"{Settings().max_clients:,}"],
        ["connections", "its process", f"{MAX_CONNECTIONS:,}"],
    ]
    note = (
        "Extrapolated, except the last two rows, which are limits. Of several rows of one kind, "
        "the smallest number is reached first."
    )
    return Table("What one of each carries", ["of what", "part", "at most"], rows, [note])


def _bytes(count: float) -> str:
    """A size with three digits and a unit that suits it."""
    for name, size in (("PB", 1e15), ("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{_digits(count / size)} {name}"
    return f"{count:.0f} B"


def _time(seconds: float) -> str:
    for name, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{_digits(seconds / size)} {name}"
    return f"{seconds:.1e} s"


def _digits(number: float) -> str:
    places = 0 if number >= 99.95 else 1 if number >= 9.995 else 2
    return f"{number:,.{places}f}"
