"""`python -m benchmarks load`: joins many clients to one room of a running server."""

import json

import click

from benchmarks.load.client import RefusedError, room_url
from benchmarks.load.generator import Load, Report, run
from plinko.app.errors import InvalidValueError

STREAMS = ("snapshots", "paths", "seeds")


@click.command(name="load", short_help="What do many clients of a running server receive?")
@click.argument("url")
@click.option("--clients", type=click.IntRange(1, 100_000), default=10, show_default=True)
@click.option(
    "--seconds", type=click.FloatRange(0.1, 86_400), default=10.0, show_default=True, metavar="S"
)
@click.option("--room", default="main", show_default=True, help="The room to join.")
@click.option("--stream", type=click.Choice(STREAMS), default="snapshots", show_default=True)
@click.option(
    "--drops", type=click.FloatRange(0.0, 1e4), default=5.0, show_default=True, metavar="N",
    help="Balls per second that one of the clients drops, so that something moves.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def load(
    url: str, clients: int, seconds: float, room: str, stream: str, drops: float, as_json: bool
) -> None:
    """Join CLIENTS clients to a room of the server at URL and print what they receive.

    Latency is the time from when a tick was due on the server until its frame was read here; pings
    estimate the offset between the two clocks. "Behind" is the latency in ticks. A gap is a tick
    without a snapshot for a client. The stream `paths` has a frame for each drop, `seeds` none;
    neither has latencies. Bytes count frames and texts.
    """
    try:
        report = run(Load(room_url(url, room, stream), clients, stream, drops), seconds)
    except (InvalidValueError, RefusedError, OSError) as error:
        raise click.ClickException(str(error)) from error
    if as_json:
        click.echo(json.dumps(report.to_dict()))
        return
    for name, value in _lines(report).items():
        click.echo(f"{name:<8}  {value}")


def _lines(report: Report) -> dict[str, str]:
    fps = sorted(report.fps)
    p50, p99, worst = (1e3 * report.latency(share) for share in (0.5, 0.99, 1.0))
    lines = {
        "clients": f"{report.connected:,} of {report.asked:,}",
        "stream": report.stream,
        "frames": f"{report.frames:,} in {report.seconds:.1f} s",
        "fps": f"{fps[len(fps) // 2]:.1f} median, {fps[0]:.1f} least",
        "latency": f"{p50:.2f} ms p50, {p99:.2f} ms p99, {worst:.2f} ms worst",
        "behind": f"{report.behind(0.99)} frames p99, {report.behind(1.0)} worst",
        "gaps": f"{report.missed:,} frames missed by {report.gappy:,} clients",
        "texts": f"{report.texts / report.seconds / report.connected:.1f} a second and client",
        "bytes": f"{report.bytes / report.seconds / report.connected:,.0f} a second and client",
        "drops": f"{report.drops:,}",
    }
    for name in ("refused", "closed", "errors"):
        counts: dict[str, int] = getattr(report, name)
        if counts:
            lines[name] = "; ".join(f"{times:,} times {what}" for what, times in counts.items())
    return lines
