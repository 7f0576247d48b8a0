"""The cost of each feature: the time of a drop with it and without it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.harness.clock import Job, in_turns, seconds_of
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.scenes import boards as scenes
from benchmarks.serving import idle
from benchmarks.speed import worlds
from plinko.engine import Board, Drop, drop, drop_many
from plinko.engine.board.materials import Material


def run(effort: Effort) -> Section:
    section = Section("features")
    _prices(section, effort)
    worlds.run(section, effort)
    idle.live(section, effort)
    return section


def _bare() -> Board:
    """A board without drag and friction, with the game's restitution."""
    return scenes.triangle(12, scenes.FULL._replace(drag=0.0, friction=0.0))


def _without_walls(board: Board) -> Board:
    """The same pegs without walls; the outer bins are wide enough for every ball."""
    edges = (-1e3, *board.bins.edges[1:-1], 1e3)
    return scenes.revised(board, walls=(), bins=replace(board.bins, edges=edges))


def _pairs() -> dict[str, tuple[Board, Board]]:
    """By feature, a board with it and a board without it."""
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


def _job(board: Board, drops: int, impacts: float) -> Job:
    """Nanoseconds per impact of a batch on one core."""
    seeds = np.arange(drops, dtype=np.uint64)

    def work() -> object:
        return drop_many(board, seeds, threads=1)

    return lambda: seconds_of(work) * 1e9 / (drops * impacts)


def _impacts(board: Board, drops: int) -> float:
    return float(drop_many(board, range(drops)).impact_count.mean())


def _each_drop(board: Board, drops: int, impacts: float, ask: Callable[[Drop], object]) -> Job:
    """Nanoseconds per impact of single drops, with the result of `ask` for each."""
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
            "What a feature costs a drop",
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
