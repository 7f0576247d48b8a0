"""What moving worlds pay for balls that touch, and for diagnostics: used, unused, never had."""

import gc
import time
from collections.abc import Callable
from contextlib import ExitStack
from importlib import import_module
from types import ModuleType

import engine
from benchmarks.harness.clock import Job, Sample, in_turns
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.scenes import boards
from benchmarks.speed import stripped
from engine import Arena, Board, World
from engine.multibody.scenes import on_board
from engine.seeding import start_x

UNUSED = 1.05
"""What an unused feature may cost: the time with it unused over that of code without it."""

EVERY = 6  # ticks from one ball to the next: then they fall apart, and touch where they may
BALLS = 200  # in the box

Done = tuple[int, str]
"""Balls times ticks that were computed, and the digest of what came of them."""


def run(section: Section, effort: Effort) -> None:
    """What balls cost that touch; what diagnostics cost those who ask, and those who do not."""
    ticks = effort.size(480, 24)
    jobs = {
        "ball-ball pairs/with": _job(lambda: _knocking(ticks)),
        "ball-ball pairs/without": _job(lambda: _passing(ticks)),
        "diagnostics/with": _job(lambda: _box(engine, ticks, asked=True)),
        "diagnostics/without": _job(lambda: _box(engine, ticks)),
    }
    same: dict[str, bool] = {}
    with ExitStack() as stack:
        if not effort.quick:  # the copy takes half a minute to compile
            other = stack.enter_context(stripped.without("diagnostics"))
            jobs["diagnostics/never"] = _job(lambda: _box(other, ticks))
            same["diagnostics"] = _box(engine, ticks) == _box(other, ticks)
            effort.step("without diagnostics")
        rounds = effort.rounds if effort.quick else max(effort.rounds, 15)
        times = in_turns(jobs, rounds, lambda: effort.step("worlds"))
    section.data["worlds"] = {name: sample.to_dict() for name, sample in times.items()}
    section.tables.append(_prices(times, ticks))
    if same:
        section.data["worlds_same_outcomes"] = same
        section.tables.append(_unused(times, same))


def _job(work: Callable[[], Done]) -> Job:
    """Nanoseconds of this thread per ball and tick."""

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
    """Balls one after the other down 12 rows of pegs, by the stepped solver of one ball."""
    world = World(boards.triangle(12, boards.FULL), solver="stepped")
    done = 0
    for tick in range(ticks):
        if tick % EVERY == 0:
            world.add(tick)
        world.step()
        world.take_events()
        done += world.count
    return done, world.digest()


def _knocking(ticks: int) -> Done:
    """The same balls, which touch each other."""
    board = boards.triangle(12, boards.FULL)
    arena = on_board(board)
    done = 0
    for tick in range(ticks):
        if tick % EVERY == 0:
            _add(arena, board, tick)
        arena.step()
        arena.take_events()
        done += arena.count
    return done, arena.digest()


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


def _box(package: ModuleType, ticks: int, *, asked: bool = False) -> Done:
    """Balls that fall to a heap in a box; `asked`: for their energies and contacts each tick."""
    make = import_module(f"{package.__name__}.multibody.scenes").sandbox
    arena = make(BALLS, seed=1, sleeping=False)
    for _ in range(ticks):
        arena.step()
        if asked:
            arena.diagnostics()
    return BALLS * ticks, arena.digest()


def _prices(times: dict[str, Sample], ticks: int) -> Table:
    rows = []
    for name in ("ball-ball pairs", "diagnostics"):
        used, unused = times[f"{name}/with"], times[f"{name}/without"]
        cells = (spread(used, "{:,.0f}"), spread(unused, "{:,.0f}"))
        rows.append([name, *cells, spread(used.over(unused), "{:.2f}")])
    return Table(
        "Price of a feature to a moving world that uses it",
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


def unused_row(name: str, unused: Sample, never: Sample, same: bool) -> list[str]:
    """What code costs that a scene does not use: both times, their ratio, and whether it is free;
    `same`: whether both came to the same outcome."""
    ratio = unused.over(never)
    return [
        name,
        spread(unused, "{:,.0f}"),
        spread(never, "{:,.0f}"),
        spread(ratio, "{:.3f}"),
        "free" if ratio.median <= UNUSED else f"above {UNUSED}",
        "yes" if same else "NO",
    ]


def _unused(times: dict[str, Sample], same: dict[str, bool]) -> Table:
    rows = []
    for name, is_same in same.items():
        rows.append(unused_row(name, times[f"{name}/without"], times[f"{name}/never"], is_same))
    return Table(
        "Price of a feature to a moving world that does not use it",
        [
            "feature",
            "unused, ns a ball and tick",
            "never had, ns a ball and tick",
            "ratio",
            "",
            "same bits",
        ],
        rows,
        [
            "The same box without the feature, against a copy of the engine with it cut out: an "
            "arena that cannot be asked for diagnostics. Same "
            "bits: the digest of the whole arena at the end. A world whose balls do not touch has "
            "no code of those that do, so there is nothing to cut. Aim: a median ratio of at most "
            f"{UNUSED}."
        ],
    )
