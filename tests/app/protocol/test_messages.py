"""The server's events are encoded as in the golden files, alone and several in a message."""

import json
from pathlib import Path
from typing import Any

import pytest

from plinko.app.protocol import messages
from plinko.app.protocol.visitors import Visitor

GOLDEN = Path(__file__).parents[2] / "golden"
EVENTS = json.loads((GOLDEN / "events.json").read_text())["events"]
KINDS = {
    "accepted": messages.Accepted,
    "contact": messages.Contact,
    "landed": messages.Landed,
    "error": messages.Error,
    "pong": messages.Pong,
    "placed": messages.Placed,
    "edited": messages.Edited,
    "removed": messages.Removed,
    "settings": messages.RoomSettings,
    "claimed": messages.Claimed,
    "presence": messages.Presence,
    "halted": messages.Halted,
    "notice": messages.Notice,
    "diagnostics": messages.Diagnostics,
    "done": messages.Done,
    "missed": messages.Missed,
    "clock": messages.Clock,
}
BRIEF = KINDS | {"accepted": messages.BriefAccepted, "landed": messages.BriefLanded}


@pytest.mark.parametrize("golden", EVENTS, ids=lambda golden: golden["value"]["type"])
def test_golden_events_encode_to_exactly_this_text(golden: dict[str, Any]) -> None:
    value = dict(golden["value"])
    kinds = BRIEF if golden.get("stream") == messages.SEEDS else KINDS
    if "visitors" in value:
        value["visitors"] = [Visitor(**each) for each in value["visitors"]]
    event = kinds[value.pop("type")](**value)
    assert messages.encode_event(event).decode() == golden["text"]
    assert json.loads(golden["text"]) == golden["value"]


def test_several_events_travel_as_an_array_one_as_an_object() -> None:
    pong = messages.Pong(t=1.0, tick=2, tick_time=2.5, server_time=3.0)
    assert isinstance(json.loads(messages.encode_events([pong])), dict)
    assert [event["type"] for event in json.loads(messages.encode_events([pong, pong]))] == [
        "pong",
        "pong",
    ]
