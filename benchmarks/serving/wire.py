"""Bytes on the wire: snapshots, segments and seeds of the same drops."""

from collections.abc import Sequence

from app.protocol import messages
from app.protocol.seeds import SeedStream
from app.protocol.wire import WireMessage
from app.rooms.independent import IndependentRoom
from app.rooms.pending import DropCommand
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from engine import Board

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
                f"{found['segments']:,.0f}",
                f"{found['segments'] / found['snapshots']:.1%}",
                f"{found['all_segments'] / found['all_snapshots']:.1%}",
                f"{found['seeds']:,.0f}",
                f"{found['seeds'] / found['all_snapshots']:.2%}",
            ])  # fmt: skip
    section.data["wire"] = data
    section.tables.append(
        Table(
            "Bytes a second of flight and ball",
            ["board", "balls", "snapshots", "segments", "ratio", "with events", "seeds", "to all"],
            rows,
            [
                "WebSocket frames with their headers, 60 ticks a second, seeds from 0 dropped at "
                "once, until all have landed. With events: the text frames counted too, of which "
                "segments need fewer. Aim: a fifth or less. Seeds: all that this stream sends, the "
                "acceptances too; to all: beside snapshots with their events and acceptances."
            ],
        )
    )


def _both(board: Board, balls: int) -> dict[str, float]:
    room = IndependentRoom("bench", board, tick_rate=60, max_balls=balls)
    room.watch_segments(True)
    names = ("snapshots", "segments", "all_snapshots", "all_segments", "seeds")
    size = dict.fromkeys(names, 0.0)
    flight = 0.0
    seeds = SeedStream(room.tick_rate, room.world.tick, board.drop)
    for seed in range(balls):
        accepted = room.drop(DropCommand(seed))
        for name in ("all_snapshots", "all_segments"):
            size[name] += _events([accepted])
        size["seeds"] += _events([seeds.brief(accepted)])
    while room.awake:
        flight += room.world.count / room.tick_rate
        events = room.step(watched=True)
        told = [event for event in events if not isinstance(event, messages.Contact)]
        pieces = room.segments()
        size["snapshots"] += len(WireMessage.of_bytes(room.snapshot()).wire)
        size["segments"] += len(WireMessage.of_bytes(pieces).wire) if pieces is not None else 0
        size["all_snapshots"] += _events(events)
        size["all_segments"] += _events(told)
        seeds.hold(events, room.world.tick)
        size["seeds"] += _events(seeds.take(room.world.tick, room.seq, awake=room.awake))
    size["all_snapshots"] += size["snapshots"]
    size["all_segments"] += size["segments"]
    return {name: value / flight for name, value in size.items()}


def _events(events: "Sequence[messages.Event]") -> int:
    return len(WireMessage.of_text(messages.encode_events(list(events))).wire) if events else 0
