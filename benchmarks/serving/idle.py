"""The cost of unwatched rooms: a tick without clients, and a thousand rooms asleep."""

import json
import time
import urllib.request

from benchmarks.harness.clock import Job, in_turns, seconds_of
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.serving.process import can_watch, serving
from plinko.engine import Board, World

BALLS = 50
TICKS = 60
READY = 60.0  # s; limit for the server's start


def live(section: Section, effort: Effort) -> None:
    """A tick of a room with balls in flight: only the engine, unwatched, watched."""
    jobs: dict[str, Job] = {
        "the engine's tick alone": _engine_tick,
        "a room nobody watches": lambda: _room_tick(watched=False),
        "a room nobody watches or films": lambda: _room_tick(watched=False, cameras_there=True),
        "a watched room, frame encoded": lambda: _room_tick(watched=True),
    }
    times = in_turns(jobs, effort.rounds, lambda: effort.step("rooms"))
    base = times["the engine's tick alone"]
    section.data["rooms"] = {name: sample.to_dict() for name, sample in times.items()}
    section.tables.append(
        Table(
            f"A tick of a room with {BALLS} balls",
            ["what", "µs a tick", "to the engine alone"],
            [
                [name, spread(sample, "{:,.0f}"), f"{sample.over(base).median:.2f}"]
                for name, sample in times.items()
            ],
            [
                f"triangle-16, the first {TICKS} ticks after {BALLS} drops at once; one core. "
                "Nobody films: with the cameras there that live pictures come from, and no viewer; "
                "what one viewer costs is said under Pictures."
            ],
        )
    )


def _engine_tick() -> float:
    world = World(Board.preset("triangle-16"))
    for seed in range(BALLS):
        world.add(seed)

    def work() -> None:
        for _ in range(TICKS):
            world.step()
            world.take_events()

    return seconds_of(work) * 1e6 / TICKS


def _room_tick(*, watched: bool, cameras_there: bool = False) -> float:
    from plinko.app.pictures.film import Cameras
    from plinko.app.rooms.independent import IndependentRoom
    from plinko.app.rooms.pending import DropCommand

    room = IndependentRoom("bench", Board.preset("triangle-16"), tick_rate=60, max_balls=BALLS)
    for seed in range(BALLS):
        room.drop(DropCommand(seed))
    cameras = Cameras(1, 1)

    def work() -> None:
        for _ in range(TICKS):
            room.step(watched=watched)
            if watched:
                room.snapshot()
            if cameras_there:
                cameras.ticked(0.0, 0.0)

    try:
        return seconds_of(work) * 1e6 / TICKS
    finally:
        cameras.close()


def server(section: Section, effort: Effort) -> None:
    """Processor time of a server whose rooms are all asleep."""
    rooms = effort.size(999, 3)  # in addition to `main`
    watch = float(effort.size(20, 1))
    if not can_watch():
        section.absent.append("idle server: its processor time is read from /proc, as on Linux")
        return
    with serving(["--max-rooms", "20000"]) as running:
        for _ in range(rooms):
            _post(f"{running.address}/api/v1/rooms", {"board": "triangle-16"})
        effort.step("idle rooms")
        time.sleep(1.0)
        before = running.cpu
        start = time.monotonic()
        time.sleep(watch)
        share = (running.cpu - before) / (time.monotonic() - start)
    effort.step("idle server")
    section.data["idle"] = {"rooms": rooms + 1, "seconds": watch, "share_of_a_core": share}
    section.tables.append(
        Table(
            "An idle server",
            ["rooms", "watched for, s", "share of a core"],
            [[f"{rooms + 1:,}", f"{watch:.0f}", f"{share:.2%}"]],
            [
                "Processor time of the server's process with all rooms open and nothing moving. "
                "Aim: below 0.5 %."
            ],
        )
    )


def _post(url: str, body: dict[str, object]) -> None:
    request = urllib.request.Request(
        url, json.dumps(body).encode(), {"Content-Type": "application/json"}
    )
    with urllib.request.urlopen(request, timeout=10.0) as answer:
        answer.read()
