"""Registered boards are bounded in number and size; the least recently used is removed."""

import pytest

from plinko.app.errors import UnknownBoardError
from plinko.app.rooms import boards
from plinko.app.rooms.boards import Boards
from plinko.engine import Board

FORM = Board.preset("triangle-8").to_dict()
SURFACES = len(FORM["pegs"]) + len(FORM["walls"])


def called(name: str) -> Board:
    return Board.from_json({**FORM, "name": name})


@pytest.mark.parametrize(("most", "surfaces"), [(2, 9 * SURFACES), (9, 2 * SURFACES)])
def test_the_longest_unused_makes_way(
    most: int, surfaces: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(boards, "MOST_SURFACES", surfaces)
    known = Boards(most)
    first, second, third = (called(name) for name in ("first", "second", "third"))
    assert known.register(first)
    assert known.register(second)
    assert known.find(first.digest) is first
    assert known.register(third)
    assert known.registered() == [first, third]
    with pytest.raises(UnknownBoardError, match=second.digest[:8]):
        known.find(second.digest)
    assert known.register(second), "it can be registered again"
    assert known.registered() == [third, second]


def test_a_board_of_more_than_all_may_have_is_kept_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(boards, "MOST_SURFACES", SURFACES - 1)
    known = Boards(9)
    for board in (called("first"), called("second")):
        assert known.register(board)
        assert known.registered() == [board]
