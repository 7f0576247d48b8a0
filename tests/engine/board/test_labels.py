"""Labels say what a ball wins: they are part of a board's digest and do not affect drops."""

import dataclasses
import hashlib
import json
from typing import Any

import pytest

from plinko.engine import Board, Label, drop, verify
from plinko.engine.board.digest import encode
from plinko.engine.errors import BoardError
from tests.engine.board.forms import EXAMPLE, Form, changed

LABELLED = changed(EXAMPLE, ("bins", "labels"), [{"text": "T-shirt", "colour": "#ff0088"}, None])


def with_labels(labels: Any) -> Form:
    return changed(EXAMPLE, ("bins", "labels"), labels)


def test_labels_survive_the_json_form() -> None:
    board = Board.from_json(LABELLED)
    assert board.bins.labels == (Label("T-shirt", "#ff0088"), None)
    assert board.to_dict() == LABELLED
    assert Board.from_json(board.to_json()) == board


def test_a_board_without_labels_keeps_every_byte_of_its_digest() -> None:
    for labels in ([], [None, None]):
        assert encode(Board.from_json(with_labels(labels))) == encode(Board.from_json(EXAMPLE))
    found = Board.preset("triangle-16").digest
    assert found == "46df2ec3ccda88b8deb45aafc0dc4e7ab959333753ada9795b391cfa2cbebc7a"


def test_the_digest_of_a_board_with_labels_ends_with_them() -> None:
    plain, labelled = Board.from_json(EXAMPLE), Board.from_json(LABELLED)
    reach_and_aim = bytes(16)
    labels = b"\2\0\0\0" + b"\7\0\0\0T-shirt" + b"\7\0\0\0#ff0088" + bytes(8)
    whole = encode(plain) + reach_and_aim + labels
    assert labelled.digest == hashlib.sha256(whole).hexdigest()


@pytest.mark.parametrize(
    "labels",
    [
        [{"text": "T-shirts", "colour": "#ff0088"}, None],
        [{"text": "T-shirt", "colour": "#ff0089"}, None],
        [{"text": "T-shirt"}, None],
        [None, {"text": "T-shirt", "colour": "#ff0088"}],
        [{"text": "T-shirt", "colour": "#ff0088"}, {"text": "T-shirt"}],
    ],
    ids=["text", "colour", "no colour", "bin", "one more"],
)
def test_every_part_of_a_label_is_in_the_digest(labels: list[Any]) -> None:
    assert Board.from_json(with_labels(labels)).digest != Board.from_json(LABELLED).digest


def test_labels_change_no_fall_and_say_what_was_won() -> None:
    plain = Board.preset("triangle-8")
    prizes = tuple(Label(f"prize {number}") for number in range(9))
    labelled = dataclasses.replace(plain, bins=dataclasses.replace(plain.bins, labels=prizes))
    for seed in range(5):
        bare, prize = drop(plain, seed), drop(labelled, seed)
        assert prize.impacts.tobytes() == bare.impacts.tobytes()
        assert bare.label is None
        assert "label" not in bare.to_dict()
        assert prize.label == f"prize {prize.bin}"
        record = json.loads(prize.to_json())
        assert record["label"] == prize.label
        assert verify(record).ok
        assert verify(record | {"label": "a car"}).field == "label"


def test_one_text_has_one_spelling() -> None:
    composed, parted = (with_labels([{"text": text}, None]) for text in ("Caf\xe9", "Cafe\u0301"))
    assert Board.from_json(parted).digest == Board.from_json(composed).digest


@pytest.mark.parametrize(
    ("labels", "field"),
    [
        *((bad, "bins.labels") for bad in ("T-shirt", [None], [None] * 3)),
        (["T-shirt", None], "bins.labels[0]"),
        ([{}, None], "bins.labels[0].text"),
        *(
            ([{"text": bad}, None], "bins.labels[0].text")
            for bad in ("", 7, "x" * 41, " T-shirt", "a\nb")
        ),
        *(
            ([None, {"text": bad}], "bins.labels[1].text")
            for bad in ("\u202etxt", "a\u2066b", "x\u0301\u0302\u0303", "\u3164")
        ),
        ([{"text": "x", "colour": "red"}, None], "bins.labels[0].colour"),
        ([{"text": "x", "colour": "#FF0000"}, None], "bins.labels[0].colour"),
        ([{"text": "x", "colour": "#ff0000\n"}, None], "bins.labels[0].colour"),
        ([{"text": "x", "prize": 1}, None], "bins.labels[0].prize"),
    ],
    ids=repr,
)
def test_a_label_that_could_not_be_shown_plainly_is_refused(labels: Any, field: str) -> None:
    with pytest.raises(BoardError) as caught:
        Board.from_json(with_labels(labels))
    assert caught.value.field == field


def test_markup_emoji_and_other_scripts_are_plain_text() -> None:
    for text in ("<b>Fish & chips</b>", "\U0001f381 a gift", "\u05e4\u05e8\u05e1", "\u8cde\u54c1"):
        board = Board.from_json(with_labels([{"text": text}, None]))
        assert board.bins.label_of(0) == text
