"""Run axe-core, which checks rules of accessibility, on a page in its present state."""

from typing import Any

from axe_playwright_python.sync_playwright import Axe

from tests.browser.screen import Screen
from tests.long import LONG

# The names of screens in looks.py that exist in both colour schemes begin like this.
_IN_BOTH = ("360x", "1280x")


def asks_axe(name: str) -> bool:
    """Whether axe checks a screen of this name: one in both schemes, or any with LONG=1."""
    return LONG or name.startswith(_IN_BOTH)


def check_axe_on(screen: Screen, name: str) -> None:
    """Check a screen of this name if axe checks such screens."""
    if asks_axe(name):
        check_axe(screen)


_ENDED = """() => Promise.allSettled(
  document.getAnimations()
    .filter((each) => Number.isFinite(each.effect?.getComputedTiming().endTime ?? Infinity))
    .map((each) => each.finished)
)"""
"""Waits for the end of all animations that have one."""


def check_axe(screen: Screen) -> None:
    """Fail if a rule is broken, with each broken rule and the elements that break it."""
    screen.page.evaluate(_ENDED)  # colours in the middle of a fade would be measured
    found = Axe().run(screen.page).response
    broken = [_told(violation) for violation in found["violations"]]
    assert not broken, "\n".join(broken)
    assert len(found["passes"]) > 10, "the rules were really run"


def _told(violation: dict[str, Any]) -> str:
    places = [
        f"    {' '.join(node['target'])}: {node['failureSummary']}" for node in violation["nodes"]
    ]
    return "\n".join([f"{violation['id']} ({violation['impact']}): {violation['help']}", *places])
