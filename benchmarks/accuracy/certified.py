"""How many bins double precision gets right, and the time and precision that proofs need."""

import time
from collections import defaultdict
from typing import Any, NamedTuple

import numpy as np

from benchmarks.harness import plots
from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table
from plinko.engine import Board
from plinko.engine.constants import KIND_CONTACT_BEGIN

BOARD = "triangle-16"
PLOT = "bench-certified.png"
STEP = 8  # bits between the precisions that are tried
LEAST = 24  # bits: the first precision that is tried
TITLE = "Double-precision bins held against proofs"


class Need(NamedTuple):
    """A drop's impacts, the bits that decide it, and whether the ball rolls or slides."""

    impacts: int
    bits: int
    stays: bool


def run(effort: Effort) -> Section:
    """The share of right bins, the cost of a proof, and the precision needed."""
    try:
        import flint  # noqa: F401
    except ImportError:
        raise MissingError("proofs need python-flint: pip install 'plinko-sim[certify]'") from None
    section = Section("certified")
    _right_bins(section, effort)
    _needs(section, effort)
    return section


def _right_bins(section: Section, effort: Effort) -> None:
    """Prove every bin of a sample, also the bins that the engine calls certain."""
    from plinko.engine.certified.many import certify_many

    drops = effort.size(1000, 3)
    board = Board.preset(BOARD)
    started = time.process_time()
    share = certify_many(board, range(drops), everything=True)
    spent = (time.process_time() - started) / drops
    section.data["right"] = share.to_dict() | {"drops": drops, "ms": 1e3 * spent}
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
    """Find the least precision that decides a drop, against its number of impacts."""
    from fractions import Fraction

    from plinko.engine.certified.certify import Effort as Bits
    from plinko.engine.certified.certify import prove
    from plinko.engine.drops.start import start_of

    found: dict[str, list[Need]] = defaultdict(list)
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
            stays = any(event.kind == KIND_CONTACT_BEGIN for event in outcome.path.events)
            found[name].append(Need(outcome.path.impacts, bits, stays))
            effort.step("precision")
    section.data["precision"] = found
    rows = []
    for name, points in found.items():
        impacts, bits_needed, _ = np.array(points, float).T
        bounces = np.array([not point.stays for point in points])
        slope = 0.0
        if bounces.sum() > 2:
            slope = float(np.polyfit(impacts[bounces], bits_needed[bounces], 1)[0])
        figures = np.median(impacts), np.median(bits_needed), bits_needed.max()
        rows.append([name, *(f"{n:.0f}" for n in figures), f"{slope * np.log10(2.0):.2f}"])
    section.tables.append(
        Table(
            "Precision that decides a drop",
            ["board", "impacts, median", "bits, median", "bits, most", "digits an impact"],
            rows,
            [
                f"The least of {LEAST}, {LEAST + STEP}, … bits at which every comparison is "
                "decided. Digits an impact: the slope over the drops that bounce to their bin; "
                "bounces that die on a peg or wall lose next to none."
            ],
        )
    )
    section.plots[PLOT] = lambda path: precision_plot(found, path)


def precision_plot(found: dict[str, list[Need]], path: str) -> None:
    """Bits needed against impacts, one point per drop; open if the ball rolled or slid."""
    figure, axes = plots.start(7.2, 4.2)
    axis: Any = axes[0]
    for (name, points), color in zip(found.items(), (plots.OURS, plots.STEPPED), strict=True):
        for stays in (False, True):
            chosen = [point for point in points if point.stays == stays]
            axis.plot(
                [point.impacts for point in chosen],
                [point.bits for point in chosen],
                "o",
                color=color,
                markerfacecolor="none" if stays else color,
                markersize=4,
                alpha=0.7,
                label=f"{name}, rolls or slides" if stays else name,
            )
    axis.axhline(53, color=plots.FLOOR, linewidth=1.0, linestyle=(0, (2, 2)))
    axis.text(axis.get_xlim()[1], 55, "double precision", fontsize=8, ha="right", color=plots.INK)
    axis.set_xlabel("impacts")
    axis.set_ylabel("bits of precision that decide the bin")
    axis.set_title("Precision needed against the number of impacts", pad=12)
    axis.legend(frameon=False, loc="upper left", fontsize=8)
    plots.finish(figure, path)
