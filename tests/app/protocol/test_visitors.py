"""Visitors' names: real names are accepted, deceptive characters are refused."""

from typing import Any

import pytest

from app.errors import InvalidValueError
from app.protocol.visitors import MAX_NAME, parse_colour, parse_name


@pytest.mark.parametrize(
    "name",
    ["Ada", "O'Neil", "José", "Nguyễn Thị", "Зоя", "שרה", "محمد", "नेहा", "小林", "N. N.", "🎯 7"],
)
def test_names_that_people_have_are_taken_as_they_are(name: str) -> None:
    assert parse_name(name) == name


def test_a_name_has_one_spelling() -> None:
    assert parse_name("Jose\u0301") == "Jos\u00e9"


@pytest.mark.parametrize(
    "name",
    [
        "",
        " ",
        " Ada",
        "Ada ",
        "A  B",
        "x" * (MAX_NAME + 1),
        "<b>Ada",
        "a&lt;",
        "Ada\n",
        "Ada\x00",
        "Ada\x1b[31m",
        "\u202eadA",  # reverses the text after it
        "A\u2066da",
        "A\u200fda",
        "Ad\u200ba",  # looks like another name
        "\ufeffAda",
        "\u3164",  # looks empty
        "\u2800",
        "Ada\ufe0f",
        "Ada\u00a0B",
        "Ada\u2028",
        "\u0301Ada",  # puts an accent on the text before it
        "A\u0336\u0337\u0338da",
        "\ud800",
        "\ue000",
        7,
        ["Ada"],
        True,
    ],
)
def test_characters_that_hide_turn_or_imitate_are_refused(name: Any) -> None:
    with pytest.raises(InvalidValueError, match=r"^name ") as refused:
        parse_name(name)
    assert refused.value.field == "name"


def test_a_colour_is_six_digits_and_nothing_that_a_style_holds() -> None:
    assert parse_colour("#57c7ff") == "#57c7ff"
    assert parse_colour(None) is None
    for colour in ("#57C7FF", "#fff", "red", "#57c7ff;x:y", "#57c7ff\n", "url(#a)", 5, True, ""):
        with pytest.raises(InvalidValueError, match=r"^colour "):
            parse_colour(colour)
