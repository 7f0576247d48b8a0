"""The three streams of a room compared: bytes and processor time for each client."""

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.serving.process import OPTIONS, Served, core_for_server, pinned, serving
from plinko.app.protocol import messages

IN_FLIGHT = 50
FALL = 4.6
"""Mean duration of a drop on triangle-16, s. The drop rate follows: IN_FLIGHT balls per FALL."""

CLIENTS = {
    messages.SNAPSHOTS: (100, 400),
    messages.PATHS: (400, 1600),
    messages.SEEDS: (400, 1600),
}
"""Two crowds per stream; the difference in cost is the cost of the additional clients."""


def compare(section: Section, effort: Effort) -> None:
    """Measure each stream with a small and then a large crowd."""
    found = {}
    for stream, crowds in CLIENTS.items():
        effort.step(f"stream {stream}")
        small, large = crowds if not effort.quick else (5, 20)
        found[stream] = _cost(stream, small, large, seconds=10.0 if not effort.quick else 2.0)
    section.data["streams"] = found
    base = found[messages.SNAPSHOTS]["core"]
    section.tables.append(
        Table(
            f"The streams of a room, {IN_FLIGHT} balls in flight",
            ["stream", "bytes/s a client", "messages/s a client", "of a core for each client",
             "clients a core", "to snapshots"],
            [
                [
                    stream,
                    f"{each['bytes']:,.0f}",
                    f"{each['messages']:.1f}",
                    f"{each['core']:.3%}",
                    f"{1.0 / each['core']:,.0f}",
                    f"{base / each['core']:.1f}",
                ]
                for stream, each in found.items()
            ],
            [
                f"triangle-16, a ball dropped every {FALL / IN_FLIGHT:.3f} s with a seed that the "
                "server draws, 60 ticks a second. Bytes and messages: what a client reads, events "
                "and frames, without the frames' headers. Of a core: what the server took more "
                "with a crowd than with one a quarter of its size, for each client more; the "
                "server on a core of its own. Aim: at most 1,500 bytes a second by seeds, and 4 "
                "times as many clients a core as by snapshots."
            ],
        )
    )  # fmt: skip


def _cost(stream: str, small: int, large: int, seconds: float) -> dict[str, float]:
    with serving(OPTIONS) as server:
        pinned(server.process, core_for_server())
        few, _ = _crowd(server, stream, small, seconds)
        many, read = _crowd(server, stream, large, seconds)
    return {"core": (many - few) / (large - small), **read}


def _crowd(
    server: Served, stream: str, clients: int, seconds: float
) -> tuple[float, dict[str, float]]:
    """The server's share of a core, and bytes and messages per second of one client."""
    from benchmarks.load.client import room_url
    from benchmarks.load.generator import Load, run

    load = Load(room_url(server.address, "main", stream), clients, stream, IN_FLIGHT / FALL)
    load.settle = FALL + 1.0
    spent: list[float] = []
    load.on_count = load.on_counted = lambda: spent.append(server.cpu)
    report = run(load, seconds)
    share = (spent[1] - spent[0]) / report.seconds
    each = report.seconds * report.connected
    read = {"bytes": report.bytes / each, "messages": (report.frames + report.texts) / each}
    return share, read
