"""A staked drop that nobody chose: checked beside the button, and again from its export alone."""

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
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    page.get_by_role("button", name="Reveal and check").click()
    expect(page.locator("#fair-verdict")).to_contain_text("Proven: neither side could choose")
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save the session").click()
    export = json.loads(saved.value.path().read_text())
    assert len(export["drops"]) == 1

    page.goto(f"{screen.url}/verify.html", wait_until="networkidle")
    page.context.set_offline(True)
    dearer = json.loads(json.dumps(export))
    dearer["drops"][0]["result"]["payout"] += 1
    for session, said in ((export, "Proven: "), (dearer, "not over yet. payout of drop 0")):
        text = json.dumps(session).encode()
        file = FilePayload(name="session.json", mimeType="application/json", buffer=text)
        page.locator("#file").set_input_files(file)
        expect(page.locator("#verdict")).to_contain_text(said)
    page.context.set_offline(False)
    screen.shot("verify")
