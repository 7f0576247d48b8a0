"""The work-precision diagram: drops per second against position error, both on log scales."""

from typing import Any

from benchmarks.harness import plots

PANELS = (0, 2)  # indices of the compared impacts that are drawn: an early and a late one
STYLE = {
    "plinko exact": (plots.OURS, "o"),
    "plinko stepped": (plots.STEPPED, "o"),
    "naive Euler": ("#5b6472", "s"),
    "Chipmunk": ("#2f6db5", "D"),
    "Box2D": ("#3f9a6b", "D"),
    "Box2D wasm": ("#3f9a6b", "^"),
    "planck": ("#7a5bb5", "^"),
    "Rapier": ("#4aa3b8", "^"),
    "matter-js": ("#a0793d", "^"),
}


def work_precision(title: str, data: dict[str, Any], path: str) -> None:
    """Two panels, an early and a late impact; one line per contestant, over its time steps."""
    figure, axes = plots.start(10.6, 4.6, columns=2)
    for axis, panel in zip(axes, PANELS, strict=True):
        _panel(axis, data, panel)
    axes[0].set_ylabel("drops per second, one core")
    axes[0].set_title(f"Run time against error: {title}", pad=14)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="center left", bbox_to_anchor=(0.91, 0.5), frameon=False, fontsize=9
    )
    figure.subplots_adjust(wspace=0.12)
    axes[1].tick_params(labelleft=False)
    plots.finish(figure, path)


def _panel(axis: Any, data: dict[str, Any], panel: int) -> None:
    by_name: dict[str, list[tuple[float, float]]] = {}
    for entry in data["entries"].values():
        point = entry["error"][panel], entry["drops_per_second"]["median"]
        by_name.setdefault(entry["contestant"], []).append(point)
    for name, points in by_name.items():
        color, marker = STYLE[name]
        ours = name == "plinko exact"
        axis.plot(
            *zip(*points, strict=True),
            marker=marker,
            color=color,
            markersize=9 if ours else 4.5,
            linewidth=1.3,
            label=name,
            zorder=4 if ours else 3,
            linestyle="" if ours else "-",
        )
    floor = data["floor"][panel]
    axis.axvline(floor, color=plots.FLOOR, linewidth=1.0, linestyle=(0, (2, 2)))
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.minorticks_off()
    axis.set_xlim(right=3.0)
    low, high = axis.get_ylim()
    axis.set_ylim(low, high * 1.6)
    axis.text(
        floor * 1.6,
        low * 1.25,
        "one rounding\nof the start",
        fontsize=8,
        color=plots.INK,
        va="bottom",
    )
    axis.set_xlabel(f"median position error after impact {data['after'][panel]}, m")
