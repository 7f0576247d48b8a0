"""The style of the plots in docs/benchmarks.md: few colours, direct labels, no decoration."""

from typing import Any

INK = "#22262e"
FAINT = "#9aa1ad"
GRID = "#e7e9ee"
OURS = "#c8352b"
STEPPED = "#e08a1e"
FLOOR = "#22262e"


def start(width: float, height: float, columns: int = 1) -> tuple[Any, list[Any]]:
    """A figure and its axes in the common style."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    mpl.rcParams.update(
        {
            "font.family": "DejaVu Sans",
            "font.size": 9.5,
            "axes.edgecolor": FAINT,
            "axes.labelcolor": INK,
            "axes.linewidth": 0.8,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.titlelocation": "left",
            "axes.titlesize": 11,
            "axes.titleweight": "bold",
            "axes.titlecolor": INK,
            "xtick.color": INK,
            "ytick.color": INK,
            "xtick.labelsize": 9,
            "ytick.labelsize": 9,
            "grid.color": GRID,
            "grid.linewidth": 0.8,
            "lines.linewidth": 1.6,
            "lines.solid_capstyle": "round",
        }
    )
    figure, axes = plt.subplots(1, columns, figsize=(width, height), dpi=160, squeeze=False)
    for axis in axes[0]:
        axis.grid(True, which="major")
        axis.set_axisbelow(True)
        axis.minorticks_off()
    return figure, list(axes[0])


def finish(figure: Any, path: str) -> None:
    """Write the figure to a file and close it."""
    from matplotlib import pyplot as plt

    figure.savefig(path, bbox_inches="tight", facecolor="white", pad_inches=0.15)
    plt.close(figure)


def growth(rows: dict[str, Any], pegs: dict[str, Any], path: str) -> None:
    """Nanoseconds per impact against the size of the board, which should give two flat lines."""
    figure, axes = start(8.2, 3.1, columns=2)
    tallest = 0.0
    for axis, data, label in (
        (axes[0], rows, "rows (the path grows with them)"),
        (axes[1], pegs, "pegs (the path stays the same)"),
    ):
        medians = [entry["median"] for entry in data["ns_per_impact"]]
        lows = [min(entry["values"]) for entry in data["ns_per_impact"]]
        highs = [max(entry["values"]) for entry in data["ns_per_impact"]]
        axis.fill_between(data["count"], lows, highs, color=OURS, alpha=0.16, linewidth=0)
        axis.plot(data["count"], medians, "o-", color=OURS, markersize=4)
        axis.set_xscale("log")
        axis.set_xlabel(label)
        shown = data["count"][:: 2 if len(data["count"]) > 6 else 1]
        axis.set_xticks(shown, [f"{n:,}" for n in shown])
        axis.minorticks_off()
        tallest = max(tallest, *highs)
    for axis in axes:
        axis.set_ylim(0.0, 1.15 * tallest)
    axes[0].set_ylabel("ns per impact, one core")
    axes[0].set_title("Cost of an impact against the size of the board", pad=12)
    finish(figure, path)
