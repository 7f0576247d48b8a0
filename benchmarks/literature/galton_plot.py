"""Plot of depth and speed on the elastic Galton board: single balls, the mean, the law."""

import numpy as np

from benchmarks.harness import plots
from benchmarks.literature.galton import GaltonBoard

SHOWN = 12
"""Balls whose curves are drawn one by one."""


def draw(found: GaltonBoard, path: str) -> None:
    """Two panels on log scales."""
    figure, axes = plots.start(9.6, 3.9, columns=2)
    for axis, values, power, name in (
        (axes[0], found.depths, 2.0 / 3.0, "depth, in radii of a disc"),
        (axes[1], found.speeds, 1.0 / 3.0, "speed"),
    ):
        some = np.where(values[:, :SHOWN] > 0.0, values[:, :SHOWN], np.nan)
        axis.loglog(found.times, some, color=plots.FAINT, linewidth=0.7)
        mean = values.mean(axis=1)
        law = mean[-1] * (found.times / found.times[-1]) ** power
        axis.loglog(found.times, law, color=plots.INK, linewidth=1.0, linestyle=(0, (4, 3)))
        axis.loglog(found.times, mean, color=plots.OURS)
        axis.set_xlabel("time")
        axis.set_ylabel(name)
        axis.set_ylim(bottom=0.1)
        axis.minorticks_off()
    axes[0].set_title("Elastic Galton board: mean (red), twelve balls, the law (dashed)", pad=10)
    axes[0].annotate(r"$t^{2/3}$", (found.times[24], 0.25 * found.depths[24].mean()))
    axes[1].annotate(r"$t^{1/3}$", (found.times[24], 0.45 * found.speeds[24].mean()))
    plots.finish(figure, path)
