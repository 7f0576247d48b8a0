"""Generates static/js/solver/log/fields.js, the server's lists of a log's fields for pages."""

import json
from pathlib import Path

from plinko.app.protocol.visitors import TAG_FIELDS
from plinko.app.rooms.drop_format import ENTRY, ENTRY_OPTIONAL, RESULT, DropFormat

FILE = Path(__file__).parents[1] / "static/js/solver/log/fields.js"

_HEAD = """\
// The fields of a room's log, as in app/rooms/drop_format.py. Generated: do not edit, but run
// python -m tools.log_fields
"""


def text() -> str:
    """The expected content of the file."""
    lists = {
        "NEEDED": DropFormat.needed,
        "OPTIONAL": DropFormat.optional,
        "ENTRY": ENTRY,
        "ENTRY_OPTIONAL": ENTRY_OPTIONAL,
        "RESULT": RESULT,
        "UNCOVERED": TAG_FIELDS,
    }
    lines = [f"export const {name} = {json.dumps(names)};\n" for name, names in lists.items()]
    return _HEAD + "".join(lines)


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
