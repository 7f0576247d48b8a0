"""Plot of error against cost on log scales, far below the error of double precision."""

from benchmarks.harness import plots
from benchmarks.literature.digits import Point

CERTIFIED = "#2f6db5"
STYLE = {
    "stepped": (plots.STEPPED, "fixed steps"),
    "double": (plots.OURS, "exact, double precision"),
    "certified": (CERTIFIED, "certified: proven bound"),
}
SHOWN = ("dt 1/3840 s", "96 bits", "128 bits", "192 bits")
LEAST = 1e-16
"""m. An error of zero in double precision is drawn here, because the scale is logarithmic."""


def draw(drops: list[Point], photon: list[Point], path: str) -> None:
    """Two panels: drops on a board, and the photon."""
    figure, axes = plots.start(9.6, 4.2, columns=2)
    for axis, points, title in (
        (axes[0], drops, "Drops on twelve rows, after impact 8"),
        (axes[1], photon, "SIAM problem 2, at t = 10"),
    ):
        for way, (colour, name) in STYLE.items():
            chosen = [point for point in points if point.way == way]
            if chosen:
                costs = [1e3 * point.seconds for point in chosen]
                errors = [
                    max(point.error, LEAST) if way != "certified" else point.error
                    for point in chosen
                ]
                axis.loglog(costs, errors, "o-", color=colour, markersize=4, label=name)
        for point in points:
            if point.label in SHOWN:
                axis.annotate(
                    point.label, (1e3 * point.seconds, point.error), textcoords="offset points",
                    xytext=(7, -3), fontsize=8, color=plots.INK,
                )  # fmt: skip
        axis.set_ylim(1e-64, 1e2)
        axis.set_yticks([10.0**-n for n in range(0, 61, 15)])
        axis.set_xticks([0.01, 0.1, 1.0, 10.0, 100.0], ["0.01", "0.1", "1", "10", "100"])
        axis.set_xlabel("milliseconds")
        axis.set_title(title, pad=10)
        axis.minorticks_off()
    axes[0].set_ylabel("error of the place, m")
    axes[0].legend(frameon=False, fontsize=9, loc="lower left")
    plots.finish(figure, path)
