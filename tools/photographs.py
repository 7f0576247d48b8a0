"""Takes the documentation's pictures of the pages: `python -m tests.repository.photographs`.

Each picture shows what the page itself chose or computed; no bin or digest is fixed here.
"""

import io
import os
import shutil
import sys
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from tests.kit.process import ServerProcess
from tests.kit.waiting import until

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser, Page

DESK = {"width": 1280, "height": 800}
WIDE = {"width": 1400, "height": 800}
PHONE = {"width": 390, "height": 844}
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu"]


@contextmanager
def chromium() -> "Iterator[Browser]":
    """A headless Chromium."""
    from playwright.sync_api import sync_playwright

    program = os.environ.get("CHROMIUM") or shutil.which("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


def table(page: "Page", address: str) -> None:
    """The live page while a player's balls fall."""
    page.goto(address)
    page.wait_for_selector("html[data-state=asleep]")
    for _ in range(30):
        page.locator("#drop").click()
        show(page, 21)


def replay(page: "Page", address: str) -> None:
    """A replay at a strong impact, with normal and impulse."""
    page.goto(f"{address}/replay.html?board=triangle-12&seed=42")
    page.wait_for_selector("html[data-state=replay]")
    impulses = page.locator("#impacts tr td:last-child").all_text_contents()[4:-1]
    strong = max(range(len(impulses)), key=lambda i: float(impulses[i].replace("–", "0")))
    page.locator("#impacts tr").nth(4 + strong).click()


def compare(page: "Page", address: str) -> None:
    """Two balls that start a nanometre apart, of which one wins 110x."""
    page.goto(f"{address}/replay.html?board=triangle-16&seed=322243&shift=1e-9&compare")
    page.wait_for_selector("html[data-state=replay]")
    time = page.get_by_label("Time of the fall")
    time.fill(str(0.98 * float(time.get_attribute("max") or 0)))


def editor(page: "Page", address: str) -> None:
    """A board in the editor after a test of a thousand balls."""
    page.goto(f"{address}/editor.html?board=triangle-8")
    page.wait_for_selector("html[data-check=good]")
    page.get_by_label("Balls").select_option("1000")
    page.get_by_role("button", name="Test-drop").click()
    page.get_by_text("1,000 test balls", exact=True).wait_for()
    page.locator("#field").focus()
    for _ in range(22):
        page.keyboard.press("PageDown")


def problem(page: "Page", address: str) -> None:
    """An error of the server, shown at the bad field."""
    page.goto(f"{address}/editor.html?board=triangle-8")
    page.wait_for_selector("html[data-check=good]")
    page.locator("#field").focus()
    for _ in range(22):
        page.keyboard.press("PageDown")
    page.keyboard.press("Control+d")
    page.wait_for_selector("html[data-check=bad]")


def sandbox(page: "Page", address: str) -> None:
    """Balls of many sizes while they fall and pile up, with their energy."""
    page.goto(f"{address}/sandbox.html")
    page.get_by_role("button", name="Reset", exact=True).click()
    page.wait_for_function(_FALLEN)


# Whether the box's clock has advanced by 1.5 s since its smallest value: a reset box starts at 0.
_FALLEN = """() => {
  const time = parseFloat(document.querySelector("[data-fact=time]")?.textContent);
  if (Number.isNaN(time)) return false;
  window.begun = Math.min(window.begun ?? time, time);
  return time - window.begun >= 1.5;
}"""

SCENES: dict[str, tuple[Callable[["Page", str], None], dict[str, int]]] = {
    "page": (table, WIDE),
    "replay": (replay, DESK),
    "compare": (compare, DESK),
    "editor": (editor, DESK),
    "problem": (problem, PHONE),
    "sandbox": (sandbox, DESK),
}
MOVING = {"page", "sandbox"}


def take(address: str, folder: Path, names: list[str] | None = None) -> None:
    """Photograph the scenes `names` (all of them by default) of a server into `folder`."""
    folder.mkdir(exist_ok=True)
    with chromium() as browser:
        for name in names or SCENES:
            scene, size = SCENES[name]
            motion = "no-preference" if name in MOVING else "reduce"
            page = browser.new_page(viewport=size, reduced_motion=motion)  # type: ignore[arg-type]
            scene(page, address.rstrip("/"))
            keep(moment(page) if name in MOVING else still(page), folder / name)
            page.close()


def film(path: Path) -> None:
    """Twenty balls on sixteen rows in ten seconds, drawn by the product's own stage."""
    import numpy as np
    from PIL import Image

    from plinko import drop
    from plinko.app.render import Stage

    drops = [drop("triangle-16", seed=seed) for seed in range(20)]
    bins = [found.bin for found in drops if found.bin is not None]  # all of them land
    stage, frames = Stage(drops[0].board, width=640, title=""), []
    for now in np.arange(0.0, 10.0, 0.05):
        ages = {number: now - 0.27 * number for number in range(len(drops))}
        falling = [n for n, age in ages.items() if 0.0 <= age < drops[n].duration]
        bodies = np.zeros(len(falling), [("id", "i4"), ("x", "f8"), ("y", "f8"), ("theta", "f8")])
        trails = {}
        for row, number in enumerate(falling):
            states = drops[number].states(np.maximum(ages[number] - np.arange(12) / 60.0, 0.0))
            bodies[row] = number, states["x"][0], states["y"][0], states["theta"][0]
            trails[number] = np.column_stack([states["x"], states["y"]])
        lit = {bins[n] for n, age in ages.items() if 0.0 <= age - drops[n].duration < 0.4}
        pixels = stage.frame(bodies, trails=trails, lit=lit)
        frames.append(Image.fromarray(pixels[int(stage.view.header) :]))
    frames[0].save(path, append_images=frames[1:], duration=50, loop=0, quality=60, method=4)


def show(page: "Page", count: int) -> None:
    """Wait for `count` frames."""
    for _ in range(count):
        page.evaluate("new Promise(requestAnimationFrame)")


def moment(page: "Page") -> bytes:
    """A screenshot after the page has been laid out and drawn."""
    show(page, 2)
    return page.screenshot()


def still(page: "Page") -> bytes:
    """A screenshot after the page has stopped changing."""
    seen = [page.screenshot()]

    def same() -> bool:
        show(page, 24)
        seen.append(page.screenshot())
        return seen[-1] == seen[-2]

    until(same)
    return seen[-1]


def keep(png: bytes, path: Path) -> None:
    """Write a screenshot: the README's as PNG, the others as WebP, which is a quarter as large."""
    from PIL import Image

    if path.name == "page":
        path.with_suffix(".png").write_bytes(png)
        return
    with Image.open(io.BytesIO(png)) as image:
        image.convert("RGB").save(path.with_suffix(".webp"), quality=90, method=6)


def main() -> None:
    """Start a server and photograph the scenes named on the command line, or all."""
    from tools.readme import IMAGES, ROOT

    film(ROOT / IMAGES / "film.webp")
    with ServerProcess("sqlite://") as server:
        take(server.url, ROOT / IMAGES, sys.argv[1:])


if __name__ == "__main__":
    main()
