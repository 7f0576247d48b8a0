"""A staked drop of a fair session is checked in the page, and again from its export alone."""

import copy
import json

from playwright.sync_api import FilePayload, expect

from tests.browser.conftest import Open, Quick


def test_a_session_is_revealed_checked_and_checked_again_offline(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page).ready()
    page = screen.page
    padlock = page.locator("#padlock")
    expect(padlock).to_have_attribute("data-open", "true")
    padlock.click()
    shown = page.locator("#fair-values code").first.inner_text()
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    page.get_by_role("button", name="Reveal and check").click()
    expect(page.locator("#fair-verdict")).to_contain_text("Proven: neither side could choose")
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save the session").click()
    export = json.loads(saved.value.path().read_text())
    assert len(export["drops"]) == 1
    assert export["heard_session"]["statement"]["server_commitment"] == shown

    page.goto(f"{screen.url}/verify.html", wait_until="networkidle")
    page.context.set_offline(True)
    dearer = copy.deepcopy(export)
    dearer["drops"][0]["result"]["payout"] += 1
    late = copy.deepcopy(export)
    late["heard_session"]["statement"]["server_commitment"] = "5" * 64
    told_late = {**export, "heard_session": None}
    for session, said, lamp in (
        (export, "Proven: neither side could choose", "Ready"),
        (dearer, "not over yet. payout of ball 0", "Failed"),
        (late, "not over yet. heard-session.", "Failed"),
        (told_late, "Not proven: that the server committed before", "Ready"),
    ):
        text = json.dumps(session).encode()
        file = FilePayload(name="session.json", mimeType="application/json", buffer=text)
        page.locator("#file").set_input_files(file)
        expect(page.locator("#verdict")).to_contain_text(said)
        expect(page.locator("#state-text")).to_have_text(lamp)
    page.context.set_offline(False)
    screen.shot("verify")
