"""The page and the engine read the same JSON, and refuse the same."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.engine import json_text
from plinko.engine.errors import JsonSyntaxError, JsonValueError
from tests.js.conftest import Run

# Each text with the value, or with the path and the reason of the refusal.
REFUSED = {
    '{"a": 1, "a": 1}': "a: the key is given twice",
    '{"pegs": [{}, {"x": 1, "y": 0, "x": 2}]}': "pegs[1].x: the key is given twice",
    '{"a": 1, "\\u0061": 2}': "a: the key is given twice",
    '{"__proto__": 1, "__proto__": 2}': "__proto__: the key is given twice",
    "[1e999]": "[0]: 1e999 is out of range",
    f'{{"a": -{"9" * 400}}}': "a: a number of 400 digits is out of range",
    f'{{"a": 1{"0" * 60}e999}}': f"a: 1{'0' * 36}... is out of range",
    "[NaN]": "[0]: NaN is not a JSON number",
    '{"a": -Infinity}': "a: -Infinity is not a JSON number",
    "Infinity": "the value: Infinity is not a JSON number",
    '["\\ud800"]': "[0]: ",
    '{"a": "x\\udc00"}': "a: ",
}

NOT_JSON = [
    "",
    " ",
    "{",
    "[1,]",
    '{"a":1,}',
    "{a:1}",
    "'a'",
    "01",
    "1.",
    ".5",
    "+1",
    "1e",
    "[1 2]",
    '{"a" 1}',
    "tru",
    '"\n"',
    '"\\x"',
    '"a',
    "1 2",
    "[]]",
    "\ufeff1",
    "\u00a01",
    "nul",
    "[" * 65 + "]" * 65,
    "-",
    "0x1",
]

VALID = [
    "0",
    "-0",
    "1.5e3",
    '"\\u00e9\\ud83d\\ude00"',
    "[]",
    "{}",
    ' { "a" : [ 1 , { } ] } ',
    "true",
    "null",
    "false",
    '{"": 0, "b": "\\""}',
    "9007199254740993",
    "-18446744073709551615",
    "1" * 100,
    "[" * 64 + "]" * 64,
    "5e-324",
    '{"__proto__": 3}',
    '"/\\/"',
    "[[1,2],[3]]",
    "1E+2",
]

READ = """
({ readJson }, texts) => {
  const whole = (_, part) => (typeof part === "bigint" ? `whole ${part}` : part);
  const shown = (value) => JSON.stringify(value, whole);
  return texts.map((text) => {
    try {
      return { value: shown(readJson(text)) };
    } catch (error) {
      if (error.name !== "JsonError") throw error;
      return { error: error.message, field: error.field };
    }
  });
}
"""


def in_page(run: Run, texts: list[str]) -> list[Any]:
    found: list[Any] = run("solver/input/json-text.js", READ, texts)
    return found


def shown(value: Any) -> Any:
    """A value as JavaScript writes it, with large whole numbers as texts."""
    match value:
        case bool() | str() | None:
            return value
        case int() if abs(value) >= 2**53:
            return f"whole {value}"
        case float() | int():
            return float(value)
        case list():
            return [shown(part) for part in value]
        case dict():
            return {key: shown(part) for key, part in value.items()}
    raise TypeError(value)


def test_both_refuse_the_same_values_for_the_same_reason(run: Run) -> None:
    for (text, why), found in zip(REFUSED.items(), in_page(run, list(REFUSED)), strict=True):
        with pytest.raises(JsonValueError) as refused:
            json_text.parse(text)
        assert str(refused.value).startswith(why), text
        assert found["error"].startswith(why), text
        assert found["field"] == refused.value.field, text


def test_both_refuse_what_is_not_json(run: Run) -> None:
    for text, found in zip(NOT_JSON, in_page(run, NOT_JSON), strict=True):
        with pytest.raises(JsonSyntaxError):
            json_text.parse(text)
        assert "JSON" in found.get("error", ""), text


def test_both_read_the_same_values(run: Run) -> None:
    for text, found in zip(VALID, in_page(run, VALID), strict=True):
        assert shown(json.loads(found["value"])) == shown(json_text.parse(text)), text


MEMBERS = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(-1e15, 1e15) | st.text(),
    lambda part: (
        st.lists(part, max_size=4) | st.dictionaries(st.text(max_size=3), part, max_size=4)
    ),
)


@given(value=MEMBERS, indent=st.sampled_from([None, 1]), ascii_only=st.booleans())
def test_whatever_is_written_is_read_alike(
    run: Run, value: Any, indent: int | None, ascii_only: bool
) -> None:
    text = json.dumps(value, indent=indent, ensure_ascii=ascii_only)
    (found,) = in_page(run, [text])
    assert shown(json.loads(found["value"])) == shown(json_text.parse(text))


FILES = """
({ readJson, textOfFile }, files) => Promise.all(files.map((bytes) => (
  textOfFile(new Blob([Uint8Array.from(bytes)])).then(readJson).catch((error) => error.message)
)))
"""


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_a_file_is_read_in_each_encoding_that_the_command_reads(run: Run, encoding: str) -> None:
    value = {"name": "Zoë", "a": [1]}
    raw = json.dumps(value, ensure_ascii=False).encode(encoding)
    assert run("solver/input/json-text.js", FILES, [list(raw)]) == [value]


def test_a_file_of_other_bytes_is_refused(run: Run) -> None:
    files = [list(b'{"name": "Zo\xeb"}'), list(b'"\xff\xfe"')]
    assert run("solver/input/json-text.js", FILES, files) == ["not JSON: not UTF-8"] * 2
