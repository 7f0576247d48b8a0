"""How the cost of an impact depends on the size of a board: on its rows and on its pegs."""

from typing import Any

from benchmarks.harness.clock import in_turns, timed
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.scenes import boards as scenes
from plinko.engine import Board, drop_many


def run(effort: Effort) -> Section:
    section = Section("growth")
    rows = (8, 16, 32) if effort.quick else (8, 16, 24, 32, 48, 64)
    widths = (16, 32) if effort.quick else (16, 32, 64, 128, 256, 626)
    by_rows = {str(n): scenes.lattice(n, 33, scenes.FULL) for n in rows}
    by_pegs = {}
    for width in widths:
        board = scenes.lattice(
            16, width, scenes.FULL
        )  # even widths: the same rows of pegs are centred
        by_pegs[f"{len(board.pegs):,}"] = board
    section.data["rows"] = _growth(
        section, effort, by_rows, "Cost against rows, 33 columns", "rows"
    )
    section.data["pegs"] = _growth(
        section, effort, by_pegs, "Cost against pegs, 16 rows: the same path", "pegs"
    )
    section.plots["bench-growth.png"] = lambda path: _plot_growth(section.data, path)
    return section


def _growth(
    section: Section, effort: Effort, boards: dict[str, Board], title: str, what: str
) -> dict[str, Any]:
    drops = effort.size(8_192, 256)
    # The first batch of a board also builds its arrays.
    impacts = {
        name: float(drop_many(board, range(drops)).impact_count.mean())
        for name, board in boards.items()
    }
    jobs = {
        name: timed(lambda board=board: drop_many(board, range(drops), threads=1))  # type: ignore[misc]
        for name, board in boards.items()
    }
    times = in_turns(jobs, effort.rounds, lambda: effort.step(what))
    per_impact = {
        name: sample.map(lambda s, each=1e9 / (drops * impacts[name]): s * each)  # type: ignore[misc]
        for name, sample in times.items()
    }
    first = per_impact[next(iter(boards))]
    section.tables.append(
        Table(
            title,
            [what, "impacts a drop", "drops/s", "ns an impact", f"to {next(iter(boards))}"],
            [
                [
                    name,
                    f"{impacts[name]:.1f}",
                    spread(times[name].map(lambda s: drops / s), "{:,.0f}"),
                    spread(per_impact[name], "{:,.0f}"),
                    f"{per_impact[name].over(first).median:.2f}",
                ]
                for name in boards
            ],
            [f"One core, {drops:,} drops a round; last column: ratio of ns, median of the rounds."],
        )
    )
    return {
        "count": [int(name.replace(",", "")) for name in boards],
        "drops_per_second": [drops / times[name].median for name in boards],
        "ns_per_impact": [per_impact[name].to_dict() for name in boards],
    }


def _plot_growth(data: dict[str, Any], path: str) -> None:
    from benchmarks.harness import plots

    plots.growth(data["rows"], data["pegs"], path)
