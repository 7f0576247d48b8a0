"""What proofs cost and need, and how many bins double precision gets right."""

import time
from collections import defaultdict
from typing import Any

import numpy as np

from benchmarks.harness import plots
from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table
from engine import Board

BOARD = "triangle-16"
PLOT = "bench-certified.png"
STEP = 8  # bits between the precisions that are tried
LEAST = 24  # bits, the first of them
TITLE = "Double-precision bins held against proofs"


def run(effort: Effort) -> Section:
    """The share of right bins, the cost of a proof, and the precision needed."""
    try:
        import flint  # noqa: F401
    except ImportError:
        raise MissingError("proofs need python-flint: pip install 'plinko-server[bench]'") from None
    section = Section("certified")
    _right_bins(section, effort)
    _needs(section, effort)
    return section


def _right_bins(section: Section, effort: Effort) -> None:
    """All bins of a sample proven: those that were called certain too."""
    from engine.certified.many import certify_many

    drops = effort.size(1000, 3)
    board = Board.preset(BOARD)
    started = time.process_time()
    share = certify_many(board, range(drops), everything=True)
    spent = (time.process_time() - started) / drops
    section.data["right"] = share.to_json() | {"drops": drops, "ms": 1e3 * spent}
    section.tables.append(
        Table(
            TITLE,
            ["board", "drops", "right", "called certain", "of these wrong", "ms a proof"],
            [
                [
                    BOARD,
                    f"{drops:,}",
                    f"{share.right / drops:.2%}",
                    f"{share.certain / drops:.1%}",
                    str(share.certain_but_wrong),
                    f"{1e3 * spent:.0f}",
                ]
            ],
            [
                f"Seeds 0 to {drops - 1}, each bin proven in ball arithmetic; {share.undecided} "
                "were left undecided. A bin is called certain by the tangents of the path alone. "
                "A proof's time is the processor's mean, the drop in double precision included.",
            ],
        )
    )


def _needs(section: Section, effort: Effort) -> None:
    """The least precision that decides a drop, against its number of impacts."""
    from fractions import Fraction

    from engine.certified.certify import Effort as Bits
    from engine.certified.certify import prove
    from engine.drops.start import start_of

    found: dict[str, list[tuple[int, int]]] = defaultdict(list)
    for name in (BOARD, "triangle-8"):
        board = Board.preset(name)
        for seed in range(effort.size(100, 1)):
            x = Fraction(start_of(board, seed, None))
            bits = LEAST
            while True:
                outcome = prove(board, x, effort=Bits(bits, bits))
                if outcome.path is not None:
                    break
                bits += STEP
            found[name].append((outcome.path.impacts, bits))
            effort.step("precision")
    section.data["precision"] = found
    rows = []
    for name, points in found.items():
        impacts, bits_needed = np.array(points, float).T
        slope = float(np.polyfit(impacts, bits_needed, 1)[0]) if len(points) > 2 else 0.0
        figures = np.median(impacts), np.median(bits_needed), bits_needed.max()
        rows.append([name, *(f"{n:.0f}" for n in figures), f"{slope * np.log10(2.0):.2f}"])
    section.tables.append(
        Table(
            "Precision that decides a drop",
            ["board", "impacts, median", "bits, median", "bits, most", "digits an impact"],
            rows,
            [f"The least of {LEAST}, {LEAST + STEP}, … bits at which every comparison is decided."],
        )
    )
    section.plots[PLOT] = lambda path: precision_plot(found, path)


def precision_plot(found: dict[str, list[tuple[int, int]]], path: str) -> None:
    """Bits needed against impacts, a point a drop."""
    figure, axes = plots.start(7.2, 4.2)
    axis: Any = axes[0]
    for (name, points), color in zip(found.items(), (plots.OURS, plots.STEPPED), strict=True):
        impacts, bits = zip(*points, strict=True)
        axis.plot(impacts, bits, "o", color=color, markersize=4, alpha=0.7, label=name)
    axis.axhline(53, color=plots.FLOOR, linewidth=1.0, linestyle=(0, (2, 2)))
    axis.text(axis.get_xlim()[1], 55, "double precision", fontsize=8, ha="right", color=plots.INK)
    axis.set_xlabel("impacts")
    axis.set_ylabel("bits of precision that decide the bin")
    axis.set_title("Precision needed against the number of impacts", pad=12)
    axis.legend(frameon=False, loc="upper left")
    plots.finish(figure, path)
