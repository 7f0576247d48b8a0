"""Visitors' names: real names are accepted, deceptive characters are refused."""

import json
import unicodedata
from pathlib import Path
from typing import Any

import pytest

from plinko.app.errors import InvalidValueError
from plinko.app.protocol.visitors import MAX_NAME, parse_colour, parse_name
from plinko.engine.plain_text import VIRAMAS

GOLDEN = json.loads((Path(__file__).parents[2] / "golden" / "names.json").read_text("utf-8"))
VALID, INVALID = (
    [pytest.param(name, id=f"{kind}-{name!a}") for kind in GOLDEN[of] for name in GOLDEN[of][kind]]
    for of in ("valid", "invalid")
)


@pytest.mark.parametrize("name", VALID)
def test_names_that_people_have_are_taken_as_they_are(name: str) -> None:
    assert parse_name(name) == unicodedata.normalize("NFC", name)
    assert parse_name("Jose\u0301") == "Jos\u00e9"


def test_every_virama_of_a_script_that_is_written_may_join() -> None:
    letters = (chr(code) for code in range(0x10000))
    assert {each for each in letters if unicodedata.combining(each) == 9} == {
        each for each in VIRAMAS if each <= "\uffff"
    }


NO_NAMES: list[Any] = [
    "", " ", " Ada", "Ada ", "A  B", "x" * (MAX_NAME + 1), "<b>Ada", "a&lt;", "Ada\n", "Ada\x00",
    "Ada\x1b[31m", "\ud800", 7, ["Ada"], True,
]  # fmt: skip


@pytest.mark.parametrize("name", [*INVALID, *NO_NAMES])
def test_what_is_no_name_hides_something_or_covers_others_is_refused(name: Any) -> None:
    with pytest.raises(InvalidValueError, match=r"^name ") as refused:
        parse_name(name)
    assert refused.value.field == "name"


def test_a_colour_is_six_digits_and_nothing_that_a_style_holds() -> None:
    assert parse_colour("#57c7ff") == "#57c7ff"
    assert parse_colour(None) is None
    for colour in ("#57C7FF", "#fff", "red", "#57c7ff;x:y", "#57c7ff\n", "url(#a)", 5, True, ""):
        with pytest.raises(InvalidValueError, match=r"^colour "):
            parse_colour(colour)
