"""A board is data: it survives its JSON form, and its digest depends only on its content."""

import copy
import dataclasses
import gc
import hashlib
import json
import math
import pickle
import struct
from pathlib import Path

import pytest
from hypothesis import given, settings

from plinko.engine.board.materials import Material
from plinko.engine.board.model import Board
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall
from plinko.engine.errors import BoardError
from tests.engine.board.forms import EXAMPLE, Form, at, box, changed, leaves, valid_forms
from tests.long import tries

SLOTTED = changed(EXAMPLE, ("drop", "slots"), [-0.5, 0.25])


@given(valid_forms())
def test_a_board_survives_its_json_form_and_the_way_to_another_process(form: Form) -> None:
    board = Board.from_json(form)
    for again in (Board.from_json(board.to_json()), pickle.loads(pickle.dumps(board))):
        assert again == board
        assert again.digest == board.digest
        assert hash(again) == hash(board)
        assert again.to_json() == board.to_json()


@given(valid_forms())
@settings(max_examples=tries(20, 200))
def test_the_json_form_holds_every_value_that_was_given(form: Form) -> None:
    written = Board.from_json(form).to_dict()
    for path in leaves(form):
        assert at(written, path) == at(form, path)


def test_the_designs_example_is_a_board() -> None:
    form = copy.deepcopy(EXAMPLE)
    board = Board.from_json(form)
    assert board.to_dict() == form == EXAMPLE, "reading does not change what is read"
    assert board.pegs == (Peg(0.0, 0.0, 0.05),)
    assert board.walls == (Wall(-4.0, -1.0, -4.0, 6.0),)
    assert board.bins == Bins(5.196, (-4.0, -3.5, 4.0), (1.0, 2.0))
    assert board.bins.count == 2
    assert board.drop == DropZone(0.0, -0.5, 0.25)
    assert board.slots == ()
    assert board.preset_name is None


def test_a_board_is_read_from_a_file_a_text_or_an_object(tmp_path: Path) -> None:
    text = json.dumps(EXAMPLE)
    path = tmp_path / "example.json"
    path.write_text(text, encoding="utf-8")
    board = Board.from_json(EXAMPLE)
    assert Board.from_json(path) == board
    assert Board.from_json(str(path)) == board
    assert Board.from_json(f" \n{text}") == board
    path.write_text(text, encoding="utf-8-sig")  # with a byte order mark
    assert Board.from_json(path) == board


def test_what_is_left_out_has_a_default_and_nothing_is_a_playable_board() -> None:
    board = Board.from_json("{}")
    assert board.bins == Bins(6.0, (-4.0, 4.0), (1.0,))
    assert [wall.x1 for wall in board.walls] == [-4.0, 4.0]
    assert all(wall.y1 < board.drop.y - board.ball.radius for wall in board.walls)
    assert board.ball == BallSpec()
    assert board.gravity == 9.81
    edges = Board.from_json({"width": 6, "bins": {"multipliers": [2, 0.5, 2]}}).bins.edges
    assert edges == (-3.0, -1.0, 1.0, 3.0), "they share the width among the multipliers"
    assert Board.from_json(box()).bins.multipliers == (1.0, 1.0)


def test_whole_numbers_are_taken_as_floats() -> None:
    form = box([(1, 3, 1)])
    board = Board.from_json(form)
    assert board == Board.from_json(box([(1.0, 3.0, 1.0)]))
    assert type(board.pegs[0].x) is float
    assert type(Board(bins=Bins(6, (-4, 4), (1,)), walls=board.walls).bins.y) is float


def test_lists_become_tuples_so_a_board_cannot_change() -> None:
    board = Board.from_json(EXAMPLE)
    assert isinstance(board.pegs, tuple)
    assert isinstance(board.bins.edges, tuple)
    with pytest.raises(dataclasses.FrozenInstanceError):
        board.gravity = 1.0  # type: ignore[misc]


def test_the_garbage_collector_skips_pegs_and_walls() -> None:
    board = Board.from_json(EXAMPLE)
    gc.collect()
    for parts in (board.pegs, board.walls):
        assert parts
        assert not any(map(gc.is_tracked, (parts, *parts)))


def test_the_digest_is_the_sha256_of_the_documented_bytes() -> None:
    data = b"plinko-board/1\n" + struct.pack("<I", 7) + b"example"
    data += struct.pack("<4d", 8.0, 6.0, 9.81, 0.0)
    data += struct.pack("<4d", 0.08, 1.0, 0.6, 0.0)
    data += struct.pack("<I3d", 1, 0.0, 0.0, 0.05)
    data += struct.pack("<2d", 0.6, 0.0)
    data += struct.pack("<I4d", 1, -4.0, -1.0, -4.0, 6.0)
    data += struct.pack("<2d", 0.6, 0.0)
    data += struct.pack("<dI3d", 5.196, 3, -4.0, -3.5, 4.0)
    data += struct.pack("<I2d", 2, 1.0, 2.0)
    data += struct.pack("<3dI2d", 0.0, -0.5, 0.25, 2, -0.5, 0.25)
    assert Board.from_json(SLOTTED).digest == hashlib.sha256(data).hexdigest()


@pytest.mark.parametrize("path", list(leaves(SLOTTED)), ids=str)
def test_the_digest_changes_with_every_single_value(path: tuple[str | int, ...]) -> None:
    value = at(SLOTTED, path)
    other = value + "!" if isinstance(value, str) else math.nextafter(value, 0.5)
    board, neighbour = Board.from_json(SLOTTED), Board.from_json(changed(SLOTTED, path, other))
    assert neighbour.digest != board.digest
    assert neighbour != board


@given(valid_forms(), valid_forms())
@settings(max_examples=tries(20, 200))
def test_two_boards_share_a_digest_exactly_if_they_are_equal(a: Form, b: Form) -> None:
    first, second = Board.from_json(a), Board.from_json(b)
    assert (first == second) == (first.digest == second.digest)


def test_the_order_of_pegs_is_content_as_impacts_refer_to_it() -> None:
    one, two = (-1.0, 3.0, 0.1), (1.0, 3.0, 0.1)
    assert Board.from_json(box([one, two])).digest != Board.from_json(box([two, one])).digest


def test_negative_zero_is_zero() -> None:
    minus = Board.from_json(changed(EXAMPLE, ("pegs", 0, "x"), -0.0))
    assert minus.digest == Board.from_json(EXAMPLE).digest
    assert math.copysign(1.0, minus.pegs[0].x) == 1.0


def test_a_changed_copy_is_checked_and_has_its_own_digest() -> None:
    board = Board.from_json(EXAMPLE)
    heavier = dataclasses.replace(board, gravity=24.79)
    assert heavier.digest == Board.from_json(changed(EXAMPLE, ("gravity",), 24.79)).digest
    with pytest.raises(BoardError, match="gravity"):
        dataclasses.replace(board, gravity=-1.0)


def test_mass_and_inertia_are_those_of_a_uniform_disc() -> None:
    ball = BallSpec(radius=0.5, density=8.0, restitution=0.7, friction=0.08)
    assert ball.mass == pytest.approx(8.0 * math.pi * 0.25, rel=1e-15)
    assert ball.inertia == pytest.approx(0.5 * ball.mass * 0.25, rel=1e-15)
    assert ball.material == Material(0.7, 0.08)


def test_the_extent_holds_every_part_and_the_ball_s_two_ends() -> None:
    x_min, x_max, y_min, y_max = Board.from_json(SLOTTED).extent
    assert (x_min, x_max) == (-4.0, 4.0)
    assert (y_min, y_max) == (-1.0, 6.0)
    wide = Board.from_json(
        {"width": 1, "bins": {"edges": [-3, 3]}, "drop": {"x": 2, "jitter": 0.5}}
    )
    assert wide.extent == (-3.0, 3.0, -0.16, 6.08)
