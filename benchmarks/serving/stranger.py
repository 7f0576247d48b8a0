"""How soon a new visitor with a phone can play and share a ball.

A real, headless Chromium plays the phone, with a network of 1.6 Mbit/s and 150 ms. It takes each
step as soon as the page allows it; the time that a person needs to understand the page is not
included.
"""

import time
from collections.abc import Callable
from statistics import median
from typing import Any, Final

from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table
from benchmarks.serving.page import FLAGS, chromium
from benchmarks.serving.process import serving

PHONES: Final = ((360, 640, 3), (390, 844, 3))
"""Width and height in CSS pixels, and device pixels per CSS pixel."""

LINE: Final = {
    "offline": False,
    "latency": 150,  # ms
    "downloadThroughput": 1.6e6 / 8,  # bytes/s
    "uploadThroughput": 0.75e6 / 8,
}

STEPS: Final = ("first paint", "DROP can be tapped", "a ball falls", "it has landed", "handed on")

_PAINT: Final = "performance.getEntriesByName('first-contentful-paint')[0].startTime"

_TAKEN: Final = """performance.getEntries().reduce(
  (sum, entry) => sum + (entry.transferSize ?? 0), 0)"""

_SHEET: Final = """
navigator.share = async () => { document.documentElement.dataset.handed = "on"; };
"""
"""Replaces the system's share sheet, which a headless browser lacks, by one that opens at once."""


def run(effort: Effort) -> Section:
    """Visit with each phone; raises MissingError without Playwright or Chromium."""
    section = Section("stranger")
    rows = []
    for width, height, density in PHONES:
        visits = []
        for _ in range(effort.size(5, 1)):
            effort.step(f"{width} x {height}")
            visits.append(visit(width, height, density))
        screen = f"{width} x {height} at {density}"
        times = [[of[step] for of in visits] for step in STEPS]
        taken = [of["taken"] for of in visits]
        rows.append([screen, *map(_spread, times), f"{max(taken) / 1e3:.0f}"])
        section.data[screen] = dict(zip([*STEPS, "taken"], [*times, taken], strict=True))
    section.tables.append(
        Table(
            "A stranger on a phone, seconds after opening the page",
            ["phone", *STEPS, "kB before DROP"],
            rows,
            [
                f"Medians (least to most) of {effort.size(5, 1)} visits, each with an empty cache, "
                "at 1.6 Mbit/s and 150 ms, server on the same machine; each step is taken as soon "
                "as the page lets it: one tap on DROP, one on Share."
            ],
        )
    )
    return section


def _spread(times: list[float]) -> str:
    return f"{median(times):.1f} ({min(times):.1f} to {max(times):.1f})"


def visit(width: int, height: int, density: int) -> dict[str, float]:
    """Seconds from opening the page to each step, and bytes loaded before the first tap."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        raise MissingError("needs Playwright, of the bench group") from error
    program = chromium()
    with serving(["--max-balls", "20"]) as server, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        page = browser.new_page(
            viewport={"width": width, "height": height},
            device_scale_factor=density,
            is_mobile=True,
            has_touch=True,
        )
        line = page.context.new_cdp_session(page)
        line.send("Network.enable")
        line.send("Network.emulateNetworkConditions", LINE)
        page.add_init_script(_SHEET)
        found = _played(page, server.address)
        browser.close()
    return found


def _played(page: Any, url: str) -> dict[str, float]:
    start = time.monotonic()

    def after(step: Callable[[], Any]) -> float:
        step()
        return time.monotonic() - start

    found = {}
    page.goto(url, wait_until="commit")
    found["DROP can be tapped"] = after(lambda: page.wait_for_selector("html[data-state=asleep]"))
    found["first paint"] = page.evaluate(_PAINT) / 1e3
    found["taken"] = page.evaluate(_TAKEN)
    page.tap("#drop")
    found["a ball falls"] = after(lambda: page.wait_for_selector("html[data-state=live]"))
    found["it has landed"] = after(lambda: page.wait_for_selector("#hand-on:not([hidden])"))
    page.tap("#hand-on")
    found["handed on"] = after(lambda: page.wait_for_selector("html[data-handed=on]"))
    return found
