"""Every page that reads a file refuses what the command refuses, and reads what it reads."""

import json

import pytest
from playwright.sync_api import FilePayload, expect

from plinko.engine import Board, drop
from tests.browser.conftest import Open
from tools.golden import session

RECORD = drop(Board.preset("triangle-8"), 7).to_dict()

# The page's address, its field for a file, where it reports, and a file that it would accept.
READERS = {
    "session": ("/verify.html", "#file", "#verdict", session.text()),
    "record": ("/replay.html?board=triangle-8&seed=1", "#check-file", "#check-note",
               json.dumps(RECORD)),
    "board": ("/editor.html", "#file", "#keep-text", Board.preset("triangle-9").to_json()),
}  # fmt: skip


def file(content: bytes) -> FilePayload:
    return FilePayload(name="given.json", mimeType="application/json", buffer=content)


@pytest.mark.parametrize("kind", READERS)
def test_a_file_with_a_key_given_twice_is_refused(opened: Open, kind: str) -> None:
    address, field, note, text = READERS[kind]
    page = opened(address).page
    page.locator("html[data-ready], html[data-state=replay], html[data-state=asleep]").wait_for()
    twice = text.replace("{", '{"again": 1, "again": 1, ', 1)
    page.locator(field).set_input_files(file(twice.encode()))
    expect(page.locator(note)).to_contain_text("again: the key is given twice")


def test_a_file_in_utf_16_is_read(opened: Open) -> None:
    address, field, note, text = READERS["record"]
    page = opened(address).state("replay").page
    page.locator(field).set_input_files(file(text.encode("utf-16")))
    expect(page.locator(note)).to_contain_text("every bit of")
    page.locator(field).set_input_files(file(b'"Zo\xeb"'))
    expect(page.locator(note)).to_contain_text("not JSON: not UTF-8")
