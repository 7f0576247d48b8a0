"""Client messages are decoded with their values; errors say what is malformed."""

import contextlib
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.app.errors import InvalidValueError, MalformedError
from plinko.app.protocol import client_messages
from plinko.engine.errors import EngineError, JsonSyntaxError


def test_a_drop_message_keeps_its_values_as_they_came() -> None:
    message = client_messages.decode_message(
        '{"type":"drop","seed":"042","x":1,"ref":[1,{"a":null}]}'
    )
    assert message == client_messages.DropMessage(seed="042", x=1, ref=[1, {"a": None}])
    assert client_messages.decode_message('{"type":"ping","t":1.5}') == client_messages.PingMessage(
        t=1.5
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("17", "object"),
        ("{}", "type"),
        ('{"type":7}', "type"),
        ('{"type":"ping"}', "t"),
        ('{"type":"ping","t":"soon"}', "t"),
        ('{"type":"drop","seed":' + "9" * 4500 + "}", "out of range"),
    ],
)
def test_the_error_names_what_is_malformed(text: str, said: str) -> None:
    with pytest.raises((MalformedError, EngineError), match=said):
        client_messages.decode_message(text)


KEYS = st.sampled_from(["type", "seed", "x", "ref", "t"])


@given(st.text(max_size=200) | st.dictionaries(KEYS, st.none() | st.text()).map(json.dumps))
def test_any_text_or_object_is_a_message_or_refused(text: str) -> None:
    with contextlib.suppress(MalformedError, EngineError):
        client_messages.decode_message(text)


def test_a_start_is_metres_and_what_is_no_number_is_named() -> None:
    for value, x in ((None, None), (1, 1.0), (-0.25, -0.25)):
        assert client_messages.parse_place(value, "x") == x
    no_numbers: list[object] = ["1", True, [], {}, math.nan, math.inf, -math.inf, 10**400]
    for wrong in no_numbers:
        with pytest.raises(InvalidValueError, match="x "):
            client_messages.parse_place(wrong, "x")


def nested(depth: int) -> str:
    return '{"type":"drop","ref":' + "[" * depth + "]" * depth + "}"


@pytest.mark.parametrize("depth", [64, 65, 500, 900, 940, 960, 980, 1000, 2000])
def test_a_note_nested_too_deeply_to_be_sent_back_is_refused(depth: int) -> None:
    """Decoding could succeed on a shallow Python stack, and encoding fail on a deeper one."""
    with pytest.raises(JsonSyntaxError, match="nested too deeply: more than 64 levels"):
        client_messages.decode_message(nested(depth))
    assert client_messages.peek(nested(depth), "ref") is None


def test_a_client_says_that_it_only_watches_or_nothing() -> None:
    assert client_messages.parse_watch("true")
    assert not client_messages.parse_watch(None)
    for bad in ("false", "1", ""):
        with pytest.raises(InvalidValueError, match="is not 'true'"):
            client_messages.parse_watch(bad)
