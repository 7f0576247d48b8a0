"""The golden messages match the schemas of the AsyncAPI document."""

import json
from pathlib import Path
from typing import Any

import httpx
import jsonschema
import pytest

from plinko.app.protocol import messages
from plinko.app.protocol.asyncapi import document, schemas
from plinko.app.protocol.client_messages import Message

REPOSITORY = Path(__file__).parents[3]
EVENTS = json.loads((REPOSITORY / "tests/golden/events.json").read_text())["events"]

SAID: list[dict[str, Any]] = [
    {"type": "drop"},
    {"type": "drop", "seed": "42", "x": 0.1, "ref": [1], "stake": 100, "who": "ann", "name": "Ada"},
    {"type": "ping", "t": 1.5},
    {"type": "resume", "run": "a", "since": 3, "key": "b"},
    {"type": "add", "x": 0.0, "y": 1.0, "ref": 1},
    {"type": "step"},
    {"type": "watch", "diagnostics": True},
    {"type": "appear", "name": "Ada", "colour": "#57c7ff"},
    {"type": "appear", "who": "3f", "audience": True},
]


def name_of(kind: str, kinds: tuple[Any, ...]) -> str:
    (found,) = [each.__name__ for each in kinds if each.__struct_config__.tag == kind]
    return str(found)


def validator(name: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(
        {"$ref": f"#/components/schemas/{name}", "components": {"schemas": schemas()}}
    )


def test_every_message_is_in_it() -> None:
    named = {each["name"] for each in document("1")["components"]["messages"].values()}
    kinds = (*messages.Event.__subclasses__(), *Message.__args__)
    assert named == {kind.__struct_config__.tag for kind in kinds}


@pytest.mark.parametrize("golden", EVENTS, ids=lambda golden: golden["value"]["type"])
def test_the_golden_events_are_what_it_describes(golden: dict[str, Any]) -> None:
    brief = (messages.BriefAccepted, messages.BriefLanded)
    others = tuple(kind for kind in messages.Event.__subclasses__() if kind not in brief)
    tag = golden["value"]["type"]
    told_briefly = golden.get("stream") == messages.SEEDS and tag != "clock"
    name = name_of(tag, brief if told_briefly else others)
    checked = validator(name)
    assert [error.message for error in checked.iter_errors(golden["value"])] == []
    for field in schemas()[name]["required"]:
        assert not checked.is_valid({k: v for k, v in golden["value"].items() if k != field})


@pytest.mark.parametrize("said", SAID, ids=lambda said: said["type"])
def test_what_clients_say_is_what_it_describes(said: dict[str, Any]) -> None:
    checked = validator(name_of(said["type"], Message.__args__))
    assert [error.message for error in checked.iter_errors(said)] == []
    assert not checked.is_valid(said | {"sede": 1})


def test_a_server_gives_it(http: httpx.Client) -> None:
    found = http.get("/asyncapi.json").json()
    assert found["channels"]["room"]["address"] == "/ws/rooms/{room}"
    assert found["info"]["version"] == http.get("/openapi.json").json()["info"]["version"]
