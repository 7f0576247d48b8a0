"""The game page's work in the browser: frames, processor time and stalls of a full room.

A real Chromium, headless and without a graphics processor, shows a room with 200 balls in flight.
The work of its main thread is read from the browser's own trace.
"""

import json
import os
import shutil
import threading
import time
import urllib.request
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table
from benchmarks.serving.process import serving

BALLS = 200
BOARD = "triangle-16"
STALL = 8.0
"""ms. A longer layout or garbage collection is visible: this is half of a frame at 60 Hz."""

SCREENS = ((1366, 768, 1), (360, 740, 3))
"""Width and height in CSS pixels, and device pixels per CSS pixel: a laptop, a phone."""

LAYOUT = ("Layout", "UpdateLayoutTree")
GARBAGE = ("MinorGC", "MajorGC", "BlinkGC.AtomicPhase")
CATEGORIES = ("devtools.timeline", "disabled-by-default-devtools.timeline", "v8")

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@dataclass(frozen=True)
class Trace:
    """The work of the page's main thread: durations by the trace's names.

    Durations are processor time of that thread, so that other load on the machine is not counted.
    """

    frames: tuple[float, ...]
    """The time at which each frame's callback began, ms."""
    durations: dict[str, tuple[float, ...]]

    @property
    def intervals(self) -> list[float]:
        """Times from frame to frame, ms."""
        return [after - before for before, after in zip(self.frames, self.frames[1:], strict=False)]

    @property
    def rate(self) -> float:
        """Frames a second."""
        return 1e3 * (len(self.frames) - 1) / (self.frames[-1] - self.frames[0])

    def of(self, names: Sequence[str]) -> list[float]:
        """All durations under these names, ms."""
        return [value for name in names for value in self.durations.get(name, ())]


def run(effort: Effort) -> Section:
    """Measure the page on each screen; raises MissingError without Playwright or Chromium."""
    seconds = effort.size(10, 1)
    section = Section("page")
    rows = []
    for width, height, density in SCREENS:
        effort.step(f"{width} x {height}")
        trace, in_flight = measure(width, height, density, seconds, effort.size(BALLS, 20))
        screen = f"{width} x {height} at {density}"
        rows.append([screen, *_figures(trace, in_flight)])
        section.data[screen] = _data(trace, in_flight)
    section.tables.append(
        Table(
            f"A table with {effort.size(BALLS, 20)} balls in the browser",
            [
                "screen",
                "balls",
                "frames/s",
                "interval, ms",
                "callback, ms",
                "painting, ms",
                f"layouts over {STALL:g} ms",
                f"collections over {STALL:g} ms",
            ],
            rows,
            [
                f"Chromium, headless, no graphics processor, server on the same machine; "
                f"{BOARD}, trails and ghost trails on, {seconds} s each. Times are medians with "
                "the 99th percentile in brackets. Intervals are wall time; all else is processor "
                "time of the page's main thread. Painting is its part of a frame after the "
                "callback. Stalls are given as number (longest, of how many)."
            ],
        )
    )
    return section


def _figures(trace: Trace, in_flight: int) -> list[str]:
    return [
        str(in_flight),
        f"{trace.rate:.1f}",
        _spread(trace.intervals),
        _spread(trace.of(["FireAnimationFrame"])),
        _spread(trace.of(["Commit"])),
        _stalls(trace.of(LAYOUT)),
        _stalls(trace.of(GARBAGE)),
    ]


def _data(trace: Trace, in_flight: int) -> dict[str, Any]:
    groups = {
        "interval": trace.intervals,
        "callback": trace.of(["FireAnimationFrame"]),
        "commit": trace.of(["Commit"]),
        "layout": trace.of(LAYOUT),
        "garbage": trace.of(GARBAGE),
    }
    return {
        "balls": in_flight,
        "frames": len(trace.frames),
        "frames_per_second": trace.rate,
        **{name: {f"p{share}": quantile(values, share) for share in (50, 95, 99, 100)}
           for name, values in groups.items()},
        "stalls": {
            "layout": sum(value > STALL for value in groups["layout"]),
            "garbage": sum(value > STALL for value in groups["garbage"]),
        },
    }  # fmt: skip


def quantile(values: Sequence[float], share: float) -> float:
    """The value that `share` percent of the values do not exceed; 0 for an empty sequence."""
    if not values:
        return 0.0
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share / 100 * len(ordered)))]


def _spread(values: Sequence[float]) -> str:
    return f"{quantile(values, 50):.1f} ({quantile(values, 99):.1f})"


def _stalls(values: Sequence[float]) -> str:
    over = sum(value > STALL for value in values)
    return f"{over} ({quantile(values, 100):.1f} of {len(values)})"


def measure(width: int, height: int, density: int, seconds: float, balls: int) -> tuple[Trace, int]:
    """Trace a room that is kept full; also returns the number of balls in flight at the end."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        raise MissingError("needs Playwright, of the bench group") from error
    program = chromium()
    flags = ["--drop-rate", "1000", "--max-balls", str(balls)]
    with serving(flags) as server, sync_playwright() as playwright:
        url = server.address
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        context = browser.new_context(
            viewport={"width": width, "height": height}, device_scale_factor=density
        )
        page = context.new_page()
        page.goto(url)
        page.wait_for_selector("html[data-state=asleep]")
        with feeding(url, balls):
            page.wait_for_selector("html[data-state=live]")
            _fill(url, balls)
            browser.start_tracing(page=page, categories=list(CATEGORIES))
            time.sleep(seconds)
            raw = browser.stop_tracing()
            in_flight = _in_flight(url)
        browser.close()
    return read(json.loads(raw)["traceEvents"]), in_flight


def read(events: Sequence[dict[str, Any]]) -> Trace:
    """Extract the page's main thread, which draws the frames, from a trace's events."""
    frames = [event for event in events if event["name"] == "FireAnimationFrame"]
    if not frames:
        raise MissingError("the trace has no frame: the page drew nothing")
    threads = Counter((event["pid"], event["tid"]) for event in frames)
    main = threads.most_common(1)[0][0]
    durations: dict[str, list[float]] = {}
    for event in events:
        if (event["pid"], event["tid"]) == main and event.get("ph") == "X":
            durations.setdefault(event["name"], []).append(_taken(event))
    starts = sorted(event["ts"] / 1e3 for event in frames if (event["pid"], event["tid"]) == main)
    return Trace(tuple(starts), {name: tuple(values) for name, values in durations.items()})


def _taken(event: dict[str, Any]) -> float:
    """Processor time in ms; wall time if the trace has no processor time."""
    taken: float = event.get("tdur", event.get("dur", 0))
    return taken / 1e3


def chromium() -> str:
    """Path of the browser: $CHROMIUM, or one on the PATH; raises MissingError if none exists."""
    program = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chrome")
    if program is None:
        raise MissingError("needs Chromium: set the environment variable CHROMIUM to its path")
    return program


@contextmanager
def feeding(url: str, balls: int) -> Iterator[None]:
    """Keep `main` full: another player drops balls without a pause."""
    from websockets.sync.client import connect

    done = threading.Event()
    with connect(f"{url.replace('http', 'ws', 1)}/ws/rooms/main") as socket:

        def drop() -> None:
            # A ball falls for about six seconds. This is twice the rate that keeps the room full;
            # the server refuses the rest.
            while not done.wait(3.0 / balls):
                socket.send('{"type": "drop"}')

        def listen() -> None:
            for _ in socket:
                pass

        threads = [threading.Thread(target=drop), threading.Thread(target=listen)]
        for thread in threads:
            thread.start()
        try:
            yield
        finally:
            done.set()
            threads[0].join()
            socket.close()
            threads[1].join()


def _in_flight(url: str) -> int:
    with urllib.request.urlopen(f"{url}/api/v1/rooms/main") as reply:
        return len(json.load(reply)["balls"])


def _fill(url: str, balls: int) -> None:
    """Wait until the room is nearly full."""
    while _in_flight(url) < 0.95 * balls:
        time.sleep(0.2)
