"""Boards, drops and batches are values: they print briefly, compare by digest, and are
read-only."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import plinko
from plinko.engine import (
    Board,
    BoardError,
    Drop,
    ParameterError,
    StaticGeometry,
    World,
    certify,
    drop,
    drop_many,
    occupancy,
    verify,
)
from plinko.engine.multibody.scenes import on_board
from plinko.engine.parameters import SolverName
from plinko.engine.payouts.record import odds_of_record

BOARD = Board.preset("triangle-8")
GRID: dict[str, Any] = {"left": -1.0, "top": 0.0, "cells_per_metre": 2.0, "shape": (4, 4)}


def values() -> dict[str, Any]:
    one = drop(BOARD, 1)
    return {
        "board": BOARD,
        "drop": one,
        "batch": drop_many(BOARD, range(50)),
        "trajectory": one.trajectory,
        "certainty": one.certainty,
        "occupancy": occupancy(BOARD, range(3), **GRID),
        "geometry": StaticGeometry.of_board(BOARD),
    }


@pytest.mark.parametrize("name", values())
def test_what_prints_fits_on_two_lines(name: str) -> None:
    text = repr(values()[name])
    assert len(text) < 200
    assert "\n" not in text


def test_what_prints_says_which_one_it_is() -> None:
    one, many = drop(BOARD, 1), drop_many(BOARD, range(50))
    assert (
        repr(BOARD) == f"<Board 'triangle-8': 52 pegs, 4 walls, 9 bins, digest {BOARD.digest[:12]}>"
    )
    assert f"seed=1 on 'triangle-8': bin {one.bin}, score {one.score:g}" in repr(one)
    assert "x=-0.5" in repr(drop("classic", x=-0.5))
    assert "of 50 on 'triangle-8'" in repr(many)
    assert many.digest[:12] in repr(many)
    assert "of 0 on" in repr(many[:0])


def test_values_are_equal_if_their_digests_are() -> None:
    again = Board.from_json(BOARD.to_json())
    assert again == BOARD
    assert again is not BOARD
    assert hash(again) == hash(BOARD)
    assert Board.preset("triangle-9") != BOARD
    assert BOARD.digest != BOARD
    one = drop(BOARD, 1)
    assert one == drop(again, "1") == drop(again, x=one.x_start)
    assert len({one, drop(BOARD, 1), drop(BOARD, 2)}) == 2
    assert one != drop(BOARD, 1, solver="stepped")
    assert one != one.digest
    many = drop_many(BOARD, range(20))
    assert many == drop_many(again, range(20), threads=1)
    assert len({many, many[:], many[:10]}) == 2
    assert many != drop_many(BOARD, range(1, 21))
    assert many != many.digest


def arrays(value: Any) -> dict[str, np.ndarray[Any, Any]]:
    """The arrays of a value, by name."""
    declared = getattr(value, "__dataclass_fields__", getattr(value, "__struct_fields__", ()))
    names = [*declared, *(("impacts",) * isinstance(value, Drop))]
    found = {name: getattr(value, name) for name in names}
    return {name: array for name, array in found.items() if isinstance(array, np.ndarray)}


@pytest.mark.parametrize(
    ("name", "count"),
    [("drop", 1), ("batch", 7), ("trajectory", 4), ("certainty", 2), ("occupancy", 2)],
)
def test_the_arrays_of_a_value_cannot_be_written(name: str, count: int) -> None:
    found = arrays(values()[name])
    assert len(found) == count
    for array in found.values():
        with pytest.raises(ValueError, match="read-only"):
            array[:] = array[:]


@pytest.mark.parametrize("solver", ["exact", "stepped"])
@pytest.mark.parametrize("start", [{}, {"xs": np.linspace(-0.1, 0.11, 5)}])
def test_a_batch_gives_each_of_its_drops(solver: SolverName, start: dict[str, Any]) -> None:
    many = drop_many("triangle-8", [7, 2**63, 9, 2**64 - 1, 11], solver=solver, **start)
    assert tuple(one.digest for one in many) == many.digests
    assert (many[1].seed, many[np.int64(3)].seed, many[-1].seed) == (2**63, 2**64 - 1, 11)
    for row, one in enumerate(many):
        assert one.bin == many.bin[row]
        assert (one.duration, one.x_end) == (many.duration[row], many.x_end[row])
        assert one.solver == many.solver
        assert one.explicit_x == bool(start)


def test_a_part_of_a_batch_is_a_batch() -> None:
    many = drop_many(BOARD, range(100))
    assert many[40:60] == drop_many(BOARD, range(40, 60))
    assert many[40:60].seed.tolist() == list(range(40, 60))
    assert many[::-1][0] == many[-1]
    assert len(many[3:3]) == 0
    assert list(many[3:3]) == []


@pytest.mark.parametrize("row", [5, -6, 2**70])
def test_a_drop_that_a_batch_has_not_is_named(row: int) -> None:
    with pytest.raises(IndexError, match=f"drop {row} is out of range: the batch has 5"):
        drop_many(BOARD, range(5))[row]


def test_a_batch_has_columns_for_tables() -> None:
    many = drop_many(BOARD, [3, 4, 2**64 - 1])
    columns = many.columns()
    assert list(columns) == [
        *("seed", "x_start", "bin", "score", "duration", "impact_count", "x_end", "landed"),
    ]
    assert {column.shape for column in columns.values()} == {(3,)}
    assert all(column.dtype.isnative for column in columns.values())
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    for one, row in zip(many, rows, strict=True):
        hits = int(np.count_nonzero(one.impacts["kind"] <= 1))
        assert row == (
            *(one.seed, one.x_start, one.bin, one.score, one.duration, hits, one.x_end, True),
        )


Takes = Callable[[Any], Any]

TAKES: dict[str, Takes] = {
    "drop": lambda board: drop(board, 1).digest,
    "drop_many": lambda board: drop_many(board, range(9)).digest,
    "occupancy": lambda board: occupancy(board, range(2), **GRID).counts.tolist(),
    "certify": lambda board: certify(board, 1).to_dict(),
    "World": lambda board: World(board).digest,
    "StaticGeometry.of_board": lambda board: StaticGeometry.of_board(board).digest,
    "on_board": lambda board: on_board(board).digest,
    "sweep": lambda board: plinko.sweep([board], 2)["x_end"].tolist(),
    "seeds_landing_in": lambda board: list(plinko.seeds_landing_in(board, 3, count=2)),
    "find_draw": lambda board: plinko.find_draw(board, [0, 0, 0, 1, 0, 0, 0, 0, 0]),
    "odds_of_record": lambda board: [odds.to_dict() for odds in odds_of_record(board)],
    "contact_sheet": lambda board: plinko.contact_sheet(board, [1], width=240),
    "density_picture": lambda board: plinko.density_picture(board, 2, width=240),
    "histogram_picture": lambda board: plinko.histogram_picture(board, range(9), width=240),
}


@pytest.mark.parametrize("takes", TAKES.values(), ids=TAKES)
def test_a_preset_may_be_given_by_its_name(takes: Takes) -> None:
    assert takes("triangle-8") == takes(BOARD)


@pytest.mark.parametrize("takes", TAKES.values(), ids=TAKES)
@pytest.mark.parametrize("wrong", ["triangel-8", "my-board.json", {"width": 1.0}, None])
def test_what_is_no_board_is_named_with_what_to_do(takes: Takes, wrong: Any) -> None:
    with pytest.raises(
        BoardError, match=r"Board or the name of a preset .* Board\.from_json"
    ) as it:
        takes(wrong)
    assert repr(wrong)[:20] in str(it.value)
    assert it.value.field == "board"


STEPPING = {
    "drop": lambda **how: drop(BOARD, 1, **how),
    "drop_many": lambda **how: drop_many(BOARD, 3, **how),
}
ROUGH: dict[str, Any] = {"dt": -5, "substeps": 0, "correction": 9.0}


@pytest.mark.parametrize("takes", STEPPING.values(), ids=STEPPING)
@pytest.mark.parametrize(("field", "value"), [*ROUGH.items(), ("dt", "abc"), ("dt", 1 / 60)])
def test_the_exact_solver_refuses_parameters_that_it_does_not_have(
    takes: Callable[..., object], field: str, value: object
) -> None:
    with pytest.raises(ParameterError, match=f"{field} {value!r} needs solver 'stepped'") as it:
        takes(**{field: value})
    assert it.value.field == field


@pytest.mark.parametrize("field", ["substeps", "correction"])
def test_an_exact_world_refuses_what_only_steps_need(field: str) -> None:
    with pytest.raises(ParameterError, match=f"{field} {ROUGH[field]} needs solver 'stepped'"):
        World(BOARD, dt=0.01, **{field: ROUGH[field]})


@pytest.mark.parametrize("solver", ["exact", "stepped"])
def test_zero_is_one_place_to_start_from(solver: SolverName) -> None:
    plus, minus = drop(BOARD, x=0.0, solver=solver), drop(BOARD, x=-0.0, solver=solver)
    assert minus == plus
    assert str(minus.x_start) == "0.0"
    assert minus.to_dict() == plus.to_dict()
    many = drop_many(BOARD, [1, 2], xs=[-0.0, 0.0], solver=solver)
    assert many.digests == (plus.digest,) * 2
    assert str(many.x_start.tolist()) == "[0.0, 0.0]"


def test_a_record_from_when_zero_had_a_sign_is_still_reproduced() -> None:
    then = (13.0, 3.0, 1.3, 0.7, 0.4, 0.7, 1.3, 3.0, 13.0)  # the board's payouts at that time
    board = replace(BOARD, bins=replace(BOARD.bins, multipliers=then))
    record = drop(board, x=0.0).to_dict()
    # The digest that earlier releases gave for the start -0.0.
    old = record | {"x": -0.0, "digest": OLD_DIGEST}
    assert verify(old).ok
    assert verify(record).ok


OLD_DIGEST = "2aea6196489b051a8ddf951a542c5b4c9077c44e9f970c7ce5f5e6ea96bcd7b9"


def test_writing_to_a_copy_of_xs_is_not_writing_to_the_callers() -> None:
    xs = np.array([-0.0, 0.1])
    drop_many(BOARD, [1, 2], xs=xs)
    xs[0] = 0.05
    assert str(xs[0]) == "0.05"
