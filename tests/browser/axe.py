"""Accessibility by rule: axe-core run over a page as it is now; no violation is let pass."""

from typing import Any

from axe_playwright_python.sync_playwright import Axe

from tests.browser.screen import Screen


def check_axe(screen: Screen) -> None:
    """Fail with each rule that is broken, and the elements that break it."""
    found = Axe().run(screen.page).response
    broken = [_told(violation) for violation in found["violations"]]
    assert not broken, "\n".join(broken)
    assert len(found["passes"]) > 10, "the rules were really run"


def _told(violation: dict[str, Any]) -> str:
    places = [
        f"    {' '.join(node['target'])}: {node['failureSummary']}" for node in violation["nodes"]
    ]
    return "\n".join([f"{violation['id']} ({violation['impact']}): {violation['help']}", *places])
