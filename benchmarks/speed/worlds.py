"""The cost of touching balls, and of diagnostics, in a moving world."""

import gc
import time
from collections.abc import Callable

from benchmarks.harness.clock import Job, Sample, in_turns
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.scenes import boards
from plinko.engine import Arena, Board, World
from plinko.engine.multibody.scenes import on_board, sandbox
from plinko.engine.seeding import start_x

EVERY = 6  # ticks from one ball to the next: balls start apart and may meet later
BALLS = 200  # in the box

Done = tuple[int, str]
"""Balls times ticks that were computed, and the digest of the result."""


def run(section: Section, effort: Effort) -> None:
    """Add a table of both costs."""
    ticks = effort.size(480, 24)
    jobs = {
        "ball-ball pairs/with": _job(lambda: _knocking(ticks)),
        "ball-ball pairs/without": _job(lambda: _passing(ticks)),
        "diagnostics/with": _job(lambda: _box(ticks, asked=True)),
        "diagnostics/without": _job(lambda: _box(ticks)),
    }
    times = in_turns(jobs, effort.rounds, lambda: effort.step("worlds"))
    section.data["worlds"] = {name: sample.to_dict() for name, sample in times.items()}
    section.tables.append(_prices(times, ticks))


def _job(work: Callable[[], Done]) -> Job:
    """A job that returns this thread's nanoseconds per ball and tick."""

    def job() -> float:
        gc.collect()
        gc.disable()
        try:
            start = time.thread_time()
            done, _ = work()
            return (time.thread_time() - start) * 1e9 / done
        finally:
            gc.enable()

    return job


def _passing(ticks: int) -> Done:
    """Balls one after another on 12 rows of pegs, by the stepped solver for single balls."""
    world = World(boards.triangle(12, boards.FULL), solver="stepped")
    done = 0
    for tick in range(ticks):
        if tick % EVERY == 0:
            world.add(tick)
        world.step()
        world.take_events()
        done += world.count
    return done, world.digest


def _knocking(ticks: int) -> Done:
    """The same balls, which collide with each other."""
    board = boards.triangle(12, boards.FULL)
    arena = on_board(board)
    done = 0
    for tick in range(ticks):
        if tick % EVERY == 0:
            _add(arena, board, tick)
        arena.step()
        arena.take_events()
        done += arena.count
    return done, arena.digest


def _add(arena: Arena, board: Board, seed: int) -> None:
    zone, ball = board.drop, board.ball
    arena.add(
        start_x(seed, zone.x, zone.jitter),
        zone.y,
        radius=ball.radius,
        density=ball.density,
        restitution=ball.restitution,
        friction=ball.friction,
    )


def _box(ticks: int, *, asked: bool = False) -> Done:
    """Balls that fall to a heap in a box; `asked`: with diagnostics each tick."""
    arena = sandbox(BALLS, seed=1, sleeping=False)
    for _ in range(ticks):
        arena.step()
        if asked:
            arena.diagnostics()
    return BALLS * ticks, arena.digest


def _prices(times: dict[str, Sample], ticks: int) -> Table:
    rows = []
    for name in ("ball-ball pairs", "diagnostics"):
        used, unused = times[f"{name}/with"], times[f"{name}/without"]
        cells = (spread(used, "{:,.0f}"), spread(unused, "{:,.0f}"))
        rows.append([name, *cells, spread(used.over(unused), "{:.2f}")])
    return Table(
        "What a feature costs a moving world",
        ["feature", "with, ns a ball and tick", "without, ns a ball and tick", "ratio"],
        rows,
        [
            f"Processor time of one thread over {ticks} ticks of 1/60 s, events taken each tick. "
            f"Ball-ball pairs: a ball every {EVERY} ticks down 12 rows, stepped solver, balls "
            "that touch against balls that pass through each other. Diagnostics: "
            f"{BALLS} balls that touch in a box, asked each tick for energies, momenta, contacts "
            "and overlap, against not asked."
        ],
    )
