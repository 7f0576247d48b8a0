"""Ambiguous JSON is refused, and the error names the place."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.engine import json_text
from plinko.engine.errors import JsonSyntaxError, JsonValueError

values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@given(values)
def test_whatever_has_one_meaning_is_read_as_it_was_written(value: Any) -> None:
    assert json_text.parse(json.dumps(value)) == value
    assert json_text.parse(json.dumps(value, ensure_ascii=False).encode()) == value


@pytest.mark.parametrize(
    ("text", "place", "why"),
    [
        ('{"a": 1, "b": 2, "a": 1}', "a", "a: the key is given twice"),
        ('{"pegs": [{"x": 0, "y": 1, "x": 0}]}', "pegs[0].x", "given twice"),
        ('{"pegs": [{"radius": NaN}]}', "pegs[0].radius", "NaN is not a JSON number"),
        ('[1, {"a": [-Infinity]}]', "[1].a[0]", "-Infinity is not a JSON number"),
        ('{"x": 1e999}', "x", "1e999 is out of range"),
        ('{"x": ' + "9" * 400 + "}", "x", "a number of 400 digits is out of range"),
        ('{"x": -' + "9" * 5000 + "}", "x", "a number of 5000 digits is out of range"),
        (r'{"name": "a\ud800b"}', "name", r"'a\ud800b' has a lone surrogate"),
        (r'{"name": "\udfff\ud800"}', "name", "has a lone surrogate"),
        (r'{"\ud800": 1}', r"\ud800", "the key has a lone surrogate"),
        ("NaN", "", "the value: NaN"),
    ],
)
def test_a_value_without_one_meaning_is_refused_by_its_place(
    text: str, place: str, why: str
) -> None:
    with pytest.raises(JsonValueError) as caught:
        json_text.parse(text)
    assert caught.value.field == place
    assert why in str(caught.value)
    str(caught.value).encode()  # the message can be encoded as UTF-8


def test_a_surrogate_pair_is_one_character() -> None:
    assert json_text.parse(r'"\ud83d\ude00"') == "\U0001f600"


@pytest.mark.parametrize("text", ["", "{", '{"a":1,}', "[1 2]", b"\xff", b"\xef\xbb\xbf{}", "'a'"])
def test_text_that_is_not_json_is_reported_as_such(text: str | bytes) -> None:
    with pytest.raises(JsonSyntaxError, match="not JSON"):
        json_text.parse(text)


@pytest.mark.parametrize("depth", [65, 900, 100_000])
def test_what_is_nested_too_deeply_to_be_written_is_refused(depth: int) -> None:
    with pytest.raises(JsonSyntaxError, match="nested too deeply: more than 64 levels"):
        json_text.parse("[" * depth + "]" * depth)


def test_brackets_in_strings_are_no_nesting() -> None:
    assert json_text.parse(json.dumps(["[" * 500, '\\"' + "{" * 500])) is not None
    assert json_text.parse("[" * 64 + "]" * 64) is not None
    assert json_text.parse("[" + ",".join(["[]"] * 500) + "]") == [[]] * 500
