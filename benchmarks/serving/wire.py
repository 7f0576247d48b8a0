"""Bytes on the wire: snapshots, paths and seeds of the same drops."""

from collections.abc import Sequence

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from plinko.app.protocol import messages
from plinko.app.protocol.seeds import SeedStream, SparseStream
from plinko.app.protocol.wire import WireMessage
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.pending import DropCommand
from plinko.engine import Board

BOARDS = ("triangle-8", "triangle-12", "triangle-16", "classic", "galton")


def compare(section: Section, effort: Effort) -> None:
    """Count the streams of the same drops on several boards, with one ball and with many."""
    rows = []
    data: dict[str, dict[str, float]] = {}
    many = effort.size(50, 5)
    for name in BOARDS:
        effort.step(f"bytes of {name}")
        for balls in (1, many):
            found = _both(Board.preset(name), balls)
            data[f"{name} {balls}"] = found
            rows.append([
                name,
                str(balls),
                f"{found['snapshots']:,.0f}",
                f"{found['paths']:,.0f}",
                f"{found['paths'] / found['snapshots']:.1%}",
                f"{found['all_paths'] / found['all_snapshots']:.1%}",
                f"{found['seeds']:,.0f}",
                f"{found['seeds'] / found['all_snapshots']:.2%}",
            ])  # fmt: skip
    section.data["wire"] = data
    section.tables.append(
        Table(
            "Bytes a second of flight and ball",
            ["board", "balls", "snapshots", "paths", "ratio", "with events", "seeds", "to all"],
            rows,
            [
                "WebSocket frames with their headers, 60 ticks a second, seeds from 0 dropped at "
                "once, until all have landed. With events: the text frames counted too, of which "
                "paths and seeds need fewer. Seeds: all that this stream sends, the acceptances "
                "too; to all: beside snapshots with their events and acceptances."
            ],
        )
    )


def _both(board: Board, balls: int) -> dict[str, float]:
    room = IndependentRoom("bench", board, tick_rate=60, max_balls=balls)
    names = ("snapshots", "paths", "all_snapshots", "all_paths", "seeds")
    size = dict.fromkeys(names, 0.0)
    flight = 0.0
    rate, tick = room.tick_rate, room.world.tick
    sparse = {"all_paths": SparseStream(rate, tick), "seeds": SeedStream(rate, tick, board.drop)}
    for seed in range(balls):
        accepted = room.drop(DropCommand(seed))
        size["all_snapshots"] += _events([accepted])
        for name, stream in sparse.items():
            size[name] += _events([stream.form(accepted)])
        size["paths"] += len(WireMessage.of_bytes(room.current_path(accepted.ball)).wire)
    while room.awake:
        flight += room.world.count / room.tick_rate
        events = room.step(watched=True)
        size["snapshots"] += len(WireMessage.of_bytes(room.snapshot()).wire)
        size["all_snapshots"] += _events(events)
        for name, stream in sparse.items():
            stream.hold(events, room.world.tick)
            size[name] += _events(stream.take(room.world.tick, room.seq, awake=room.awake))
    size["all_snapshots"] += size["snapshots"]
    size["all_paths"] += size["paths"]
    return {name: value / flight for name, value in size.items()}


def _events(events: "Sequence[messages.Event]") -> int:
    return len(WireMessage.of_text(messages.encode_events(list(events))).wire) if events else 0
