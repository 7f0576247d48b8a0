"""The price of each feature to a scene that uses it, and to one that does not."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.harness.clock import Job, in_turns, seconds_of
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.scenes import boards as scenes
from benchmarks.serving import idle
from benchmarks.speed import stripped, worlds
from benchmarks.speed.worlds import UNUSED, unused_row
from engine import Board, Drop, drop, drop_many
from engine.board.materials import Material

DROPS = ("nothing", "drag", "friction", "walls", "recording")
"""Cuts whose price is one of drops; the other's is one of moving worlds."""


def run(effort: Effort) -> Section:
    """All of the feature benchmark."""
    section = Section("features")
    _prices(section, effort)
    _unused(section, effort)
    worlds.run(section, effort)
    idle.live(section, effort)
    return section


def _bare() -> Board:
    """No drag, no friction, restitution as in play."""
    return scenes.triangle(12, scenes.FULL._replace(drag=0.0, friction=0.0))


def _without_walls(board: Board) -> Board:
    """The same pegs in the open, with the outer bins made wide enough for all."""
    edges = (-1e3, *board.bins.edges[1:-1], 1e3)
    return scenes.revised(board, walls=(), bins=replace(board.bins, edges=edges))


def _pairs() -> dict[str, tuple[Board, Board]]:
    """Feature: the board with it, and the board without it."""
    bare = _bare()
    rough = Material(bare.peg_material.restitution, scenes.FULL.friction)
    rubbing = replace(
        bare,
        ball=replace(bare.ball, friction=scenes.FULL.friction),
        peg_material=rough,
        wall_material=rough,
    )
    return {
        "drag": (replace(bare, drag=scenes.FULL.drag), bare),
        "friction and spin": (rubbing, bare),
        "walls": (bare, _without_walls(bare)),
    }


def _job(board: Board, drops: int, impacts: float, engine_drop_many: Any = drop_many) -> Job:
    """Nanoseconds per impact of a batch on one core."""
    seeds = np.arange(drops, dtype=np.uint64)

    def work() -> object:
        return engine_drop_many(board, seeds, threads=1)

    return lambda: seconds_of(work) * 1e9 / (drops * impacts)


def _impacts(board: Board, drops: int) -> float:
    return float(drop_many(board, range(drops)).impact_count.mean())


def _each_drop(board: Board, drops: int, impacts: float, ask: Callable[[Drop], object]) -> Job:
    """Nanoseconds per impact of single drops, each asked for something."""
    ask(drop(board, 0))

    def work() -> object:
        return [ask(drop(board, seed)) for seed in range(drops)]

    return lambda: seconds_of(work) * 1e9 / (drops * impacts)


def _prices(section: Section, effort: Effort) -> None:
    drops = effort.size(4096, 128)
    jobs: dict[str, Job] = {}
    pairs = _pairs()
    for name, (with_it, without) in pairs.items():
        for label, board in (("with", with_it), ("without", without)):
            jobs[f"{name}/{label}"] = _job(board, drops, _impacts(board, drops))
    bare = _bare()
    some = effort.size(512, 16)
    per_drop = _impacts(bare, some)
    alone = _each_drop(bare, some, per_drop, lambda found: found.x_end)
    jobs["the whole path of each drop/with"] = _each_drop(
        bare, some, per_drop, lambda found: found.impacts
    )
    jobs["the whole path of each drop/without"] = _job(bare, some, per_drop)
    jobs["tangents: how sure each drop is/with"] = _each_drop(
        bare, some, per_drop, lambda found: found.amplification
    )
    jobs["tangents: how sure each drop is/without"] = alone
    times = in_turns(jobs, effort.rounds, lambda: effort.step("prices"))
    names = [*pairs, "the whole path of each drop", "tangents: how sure each drop is"]
    rows, data = [], {}
    for name in names:
        used, unused = times[f"{name}/with"], times[f"{name}/without"]
        ratio = used.over(unused)
        rows.append(
            [name, *(spread(x, "{:,.0f}") for x in (used, unused)), spread(ratio, "{:.2f}")]
        )
        data[name] = {"with": used.to_dict(), "without": unused.to_dict()}
    section.data["prices"] = data
    section.tables.append(
        Table(
            "Price of a feature to a scene that uses it",
            ["feature", "with, ns an impact", "without, ns an impact", "ratio"],
            rows,
            [
                "12 rows, exact solver, one core; per impact, since a feature also changes how "
                "many there are. Walls: the same pegs with and without the sides. The whole path: "
                "one `drop` a seed from Python with its events, against a batch that keeps only "
                "outcomes; nearly all of it is Python. Tangents: a `drop` asked for its "
                "`amplification` against one that is not."
            ],
        )
    )


def _unused(section: Section, effort: Effort) -> None:
    """The engine on a scene that does not use a feature, against the engine without its code."""
    drops = effort.size(4096, 128)
    bare = _bare()
    boards = dict.fromkeys(DROPS, bare) | {"walls": _without_walls(bare)}
    if effort.quick:  # each copy takes half a minute to compile
        boards = {"friction": bare}
    rows: list[list[str]] = []
    data: dict[str, dict[str, Any]] = {}
    with ExitStack() as stack:
        jobs: dict[str, Job] = {}
        for name, board in boards.items():
            other = stack.enter_context(stripped.without(name))
            theirs = scenes.twin(other, board)
            impacts = _impacts(board, drops)
            ours_done = drop_many(board, range(drops))
            theirs_done = other.drop_many(theirs, range(drops))
            same = bool(
                (ours_done.bin == theirs_done.bin).all()
                and (ours_done.x_end == theirs_done.x_end).all()
                and (ours_done.duration == theirs_done.duration).all()
            )
            data[name] = {"same_outcomes": same}
            jobs[f"{name}/unused"] = _job(board, drops, impacts)
            jobs[f"{name}/never"] = _job(theirs, drops, impacts, other.drop_many)
            effort.step(f"without {name}")
        rounds = effort.rounds if effort.quick else max(effort.rounds, 15)
        times = in_turns(jobs, rounds, lambda: effort.step("unused"))
    for name in boards:
        unused, never = times[f"{name}/unused"], times[f"{name}/never"]
        rows.append(unused_row(name, unused, never, data[name]["same_outcomes"]))
        data[name] |= {"unused": unused.to_dict(), "never": never.to_dict()}
    section.data["unused"] = data
    section.tables.append(
        Table(
            "Price of a feature to a scene that does not use it",
            [
                "feature",
                "unused, ns an impact",
                "never had, ns an impact",
                "ratio",
                "",
                "same bits",
            ],
            rows,
            [
                "Never had: a copy of the engine with the feature cut out of its source, compiled "
                "by itself, run in turns with the whole engine on the same board; the outcomes of "
                "both are compared. `nothing` is the control: a copy with nothing cut out, whose "
                "ratio shows how far the measurement itself is off. "
                f"Aim: a median ratio of at most {UNUSED}."
            ],
        )
    )
