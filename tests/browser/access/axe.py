"""Accessibility by rule: axe-core run over a page as it is now; no violation is let pass."""

from typing import Any

from axe_playwright_python.sync_playwright import Axe

from tests.browser.screen import Screen
from tests.long import LONG

# Of the screens in looks.py, those that come in both colour schemes.
_IN_BOTH = ("360x", "1280x")


def asks_axe(name: str) -> bool:
    """Whether axe looks at a screen of this name: with LONG=1 at each, else at those in both."""
    return LONG or name.startswith(_IN_BOTH)


def check_axe_on(screen: Screen, name: str) -> None:
    """`check_axe` on a screen of this name, if axe looks at it."""
    if asks_axe(name):
        check_axe(screen)


_ENDED = """() => Promise.allSettled(
  document.getAnimations()
    .filter((each) => Number.isFinite(each.effect?.getComputedTiming().endTime ?? Infinity))
    .map((each) => each.finished)
)"""
"""Waits for all animations that end."""


def check_axe(screen: Screen) -> None:
    """Fail with each rule that is broken, and the elements that break it."""
    screen.page.evaluate(_ENDED)  # colours halfway through a fade are nobody's
    found = Axe().run(screen.page).response
    broken = [_told(violation) for violation in found["violations"]]
    assert not broken, "\n".join(broken)
    assert len(found["passes"]) > 10, "the rules were really run"


def _told(violation: dict[str, Any]) -> str:
    places = [
        f"    {' '.join(node['target'])}: {node['failureSummary']}" for node in violation["nodes"]
    ]
    return "\n".join([f"{violation['id']} ({violation['impact']}): {violation['help']}", *places])
