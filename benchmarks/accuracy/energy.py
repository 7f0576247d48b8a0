"""How well each contestant keeps energy: ten elastic seconds, and one bounce on a level floor."""

from collections.abc import Sequence

import numpy as np

from benchmarks.contestants.common import Contestant, Paths
from benchmarks.contestants.ours import Exact
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.scenes import boards
from plinko.engine import Board, drop

SECONDS = 10.0
HEIGHTS = tuple(0.5 + 0.137 * i for i in range(8))  # m; each meets the floor at another phase
RESTITUTION = 0.7


def elastic(
    section: Section, everyone: Sequence[Contestant], rates: Sequence[int], effort: Effort
) -> None:
    """Energy drift over ten seconds in a closed box with pegs, all elastic."""
    board = boards.elastic_box()
    balls = effort.size(32, 2)
    zone = board.drop
    xs = zone.x + np.random.default_rng(3).uniform(-zone.jitter, zone.jitter, balls)
    rows, data = [], {}
    for contestant in everyone:
        for rate in rates if contestant.stepped else (0,):
            paths = contestant.paths(board, xs, 1.0 / (rate or 240), SECONDS)
            drift = _drift(board, paths)
            name = f"{contestant.name} 1/{rate}" if rate else contestant.name
            rows.append([name, *(f"{value:+.2g}" for value in drift)])
            data[name] = dict(zip(("median", "lowest", "highest"), drift, strict=True))
            effort.step("energy")
    section.data["elastic"] = data
    section.tables.append(
        Table(
            "Energy after ten elastic seconds, relative to the start",
            ["contestant, dt in s", "median change", "lowest", "highest"],
            rows,
            [
                f"e = 1, no friction, no drag, {balls} balls in a closed box of 3 m by 3 m with "
                "nine pegs, at rest 0.5 m below its top; energy is counted from the floor up. "
                "Every change is an error."
            ],
        )
    )


def _drift(board: Board, paths: Paths) -> tuple[float, float, float]:
    """Median, lowest and highest relative change of mechanical energy over the whole path."""
    floor = max(wall.y1 for wall in board.walls) - board.ball.radius

    def energy(row: int) -> object:
        height = floor - paths.positions[row, :, 1]
        return 0.5 * (paths.velocities[row] ** 2).sum(axis=1) + board.gravity * height

    change = np.asarray(energy(-1)) / np.asarray(energy(0)) - 1.0
    return float(np.median(change)), float(change.min()), float(change.max())


def bounces(
    section: Section, everyone: Sequence[Contestant], rates: Sequence[int], effort: Effort
) -> None:
    """Height after one bounce, from which e = sqrt(h' / h) follows; it should be 0.7."""
    heights = HEIGHTS[:2] if effort.quick else HEIGHTS
    rows, data = [], {}
    for contestant in everyone:
        for rate in rates if contestant.stepped else (0,):
            found = np.array([_restitution(contestant, rate, height) for height in heights])
            name = f"{contestant.name} 1/{rate}" if rate else contestant.name
            error = np.abs(found - RESTITUTION)
            worst = f"{error.max():.4f}" if error.max() > 1e-9 else f"{error.max():.0e}"
            rows.append([name, f"{np.median(found):.4f}", worst])
            data[name] = found.tolist()
            effort.step("bounces")
    section.data["bounces"] = {"heights": list(heights), "restitution": data}
    section.tables.append(
        Table(
            "Effective restitution of one vertical bounce, 0.7 asked for",
            ["contestant, dt in s", "median", "largest error"],
            rows,
            [
                f"sqrt(h'/h) over {len(heights)} heights from {min(heights):.2f} to "
                f"{max(heights):.2f} m, which meet the floor at different phases of the step; "
                "h' is the highest point after the bounce, of stepped contestants at a step's end."
            ],
        )
    )


def _restitution(contestant: Contestant, rate: int, height: float) -> float:
    board = boards.bare_floor(RESTITUTION, height)
    fall = float(np.sqrt(2.0 * height / board.gravity))
    rise = RESTITUTION * fall
    if not rate:
        apex = _exact_apex(contestant, board, fall, rise)
    else:
        paths = contestant.paths(board, np.zeros(1), 1.0 / rate, fall + 1.5 * rise)
        y = paths.positions[:, 0, 1]
        lowest = int(np.argmax(y))
        apex = float(y[lowest:].min())
    return float(np.sqrt(max(0.0, -apex - board.ball.radius) / height))


def _exact_apex(contestant: Contestant, board: Board, fall: float, rise: float) -> float:
    """y at the instant at which the ball turns, which the exact solver can compute."""
    assert isinstance(contestant, Exact)
    hit = drop(board, x=0.0).impacts[0]
    turn = float(hit["t"]) - float(hit["vy"]) / board.gravity
    return float(drop(board, x=0.0).states([turn])["y"][0])
