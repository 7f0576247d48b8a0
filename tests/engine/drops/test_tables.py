"""Batches are tables, which are filtered, joined, and taken by pandas, polars and Arrow."""

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas
import polars
import pyarrow
import pytest

from plinko.engine import (
    Board,
    DropBatch,
    MissingPartError,
    ParameterError,
    concat,
    drop,
    drop_many,
    sweep,
)

BOARD = Board.preset("triangle-8")
SEEDS = [3, 4, 2**64 - 1, *range(100, 140)]

READERS: dict[str, Callable[[Any], Any]] = {
    "pandas": lambda batch: pandas.DataFrame(batch.columns()),
    "pandas, Arrow": pandas.DataFrame.from_arrow,
    "polars": polars.DataFrame,
    "polars, columns": lambda batch: polars.DataFrame(batch.columns()),
    "pyarrow": lambda batch: pyarrow.table(batch).to_pandas(),
    "to_arrow": lambda batch: batch.to_arrow().to_pandas(),
}


@pytest.fixture
def many() -> DropBatch:
    return drop_many(BOARD, SEEDS)


@pytest.fixture
def no_drop_is_recomputed(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("a drop is computed again")

    monkeypatch.setattr("plinko.engine.drops.batch.make_drop", refuse)


@pytest.mark.usefixtures("no_drop_is_recomputed")
@pytest.mark.parametrize("reader", READERS.values(), ids=READERS)
def test_readers_of_tables_take_a_batch_without_computing_a_drop(
    reader: Callable[[Any], Any], many: DropBatch
) -> None:
    frame = reader(many)
    assert list(frame.columns) == list(many.columns())
    for name, column in many.columns().items():
        assert frame[name].to_numpy().tolist() == column.tolist()
        assert frame[name].to_numpy().dtype == column.dtype
    assert len(reader(many[:0])) == 0
    assert list(reader(many[:0]).columns) == list(many.columns())


@pytest.mark.usefixtures("no_drop_is_recomputed")
@pytest.mark.parametrize("reader", [pandas.DataFrame, np.asarray])
def test_a_reader_of_rows_is_told_to_take_the_columns(
    reader: Callable[[Any], Any], many: DropBatch
) -> None:
    with pytest.raises(TypeError, match=r"use one, such as batch\.score, or columns\(\)"):
        reader(many)


def test_without_pyarrow_a_batch_names_what_to_install(
    many: DropBatch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingPartError, match=r"plinko-sim\[table\]"):
        many.to_arrow()


def test_a_mask_or_an_array_of_integers_selects_drops(many: DropBatch) -> None:
    third = many[many.bin == 3]
    assert 0 < len(third) < len(many)
    assert set(third.bin) == {3}
    assert third.seed.tolist() == many.seed[many.bin == 3].tolist()
    assert third[0] == drop(BOARD, int(third.seed[0]))
    for rows in ([5, 2, -1], np.array([5, 2, -1]), pandas.Series([5, 2, -1])):
        chosen = many[rows]
        assert chosen.seed.tolist() == [SEEDS[5], SEEDS[2], SEEDS[-1]]
        assert chosen == drop_many(BOARD, chosen.seed)
    assert len(many[np.array([])]) == 0
    one = drop_many(BOARD, 1)
    assert (one[np.array([True])], one[np.array([0])]) == (one, one)
    assert len(many[many.bin > 99]) == 0
    with pytest.raises(ValueError, match="read-only"):
        third.score[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        third.bin[0] = 1


@pytest.mark.parametrize(
    ("which", "said"),
    [
        ([True, False], "mask has 2 values: the batch has 43"),
        ([0.5], "no drops at"),
        ("score", "no drops at"),
        ([[1, 2]], "no drops at"),
        ([99], "99"),
    ],
)
def test_what_selects_no_drops_is_named(many: DropBatch, which: Any, said: str) -> None:
    with pytest.raises(IndexError, match=said):
        many[which]


@pytest.mark.parametrize("start", [{}, {"aim": 0.0}])
def test_batches_are_joined_in_their_order(start: dict[str, Any]) -> None:
    parts = [drop_many("classic", seeds, **start) for seeds in (range(5), [9], range(5, 9), [])]
    joined = concat(parts)
    assert joined == drop_many("classic", [0, 1, 2, 3, 4, 9, 5, 6, 7, 8], **start)
    assert joined[5] == parts[1][0]
    with pytest.raises(ValueError, match="read-only"):
        joined.seed[0] = 1


def test_batches_that_do_not_belong_together_are_not_joined(many: DropBatch) -> None:
    others = {
        "board": drop_many("triangle-9", 3),
        "solver": drop_many(BOARD, 3, solver="stepped"),
        "explicit_x": drop_many(BOARD, xs=[0.0]),
    }
    for name, other in others.items():
        with pytest.raises(ParameterError, match=rf"batches\[1\] has {name} ") as it:
            concat([many, other])
        assert it.value.field == "batches[1]"
    with pytest.raises(ParameterError, match="batches is empty"):
        concat([])


@pytest.mark.parametrize(
    "xs", [[0.25, -0.125], (0.25, -0.125), np.array([0.25, -0.125], np.float32)]
)
def test_starts_need_no_seeds_and_may_be_of_any_numbers(xs: Any) -> None:
    many = drop_many(BOARD, xs=xs)
    assert many.digests == tuple(drop(BOARD, x=x).digest for x in (0.25, -0.125))
    assert many.digests == tuple(drop(BOARD, x=x).digest for x in xs)
    assert many.seed.tolist() == [0, 1]
    assert many == drop_many(BOARD, [7, 8], xs=xs)


@pytest.mark.parametrize(
    ("xs", "said"),
    [(["left"], "are not numbers"), ([[0.1]], "2 dimensions"), ([np.float32(9)], "x 9.0 is not")],
)
def test_starts_that_are_none_are_named(xs: Any, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        drop_many(BOARD, xs=xs)


def test_a_sweep_drops_the_same_seeds_on_each_board() -> None:
    told: list[int] = []
    boards = {e: BOARD.with_restitution(e) for e in (0.3, 0.5, 0.7)}
    table = sweep(boards, 500, progress=told.append)
    frame = pandas.DataFrame(table)
    assert list(frame.columns) == ["board", *drop_many(BOARD, 1).columns()]
    assert told == sorted(told)
    assert told[-1] == 1500
    for e, rows in frame.groupby("board"):
        expected = drop_many(boards[float(str(e))], 500)
        assert rows["seed"].tolist() == list(range(500))
        assert rows["x_end"].tolist() == expected.x_end.tolist()
    assert polars.DataFrame(table).height == pyarrow.table(table).num_rows == 1500


def test_a_sweep_over_presets_has_their_names() -> None:
    table = sweep(["triangle-8", Board.preset("classic")], [5, 6], solver="stepped")
    assert table["board"].tolist() == ["triangle-8"] * 2 + ["classic"] * 2
    assert table["bin"].tolist()[2:] == drop_many("classic", [5, 6], solver="stepped").bin.tolist()


@pytest.mark.parametrize(
    ("boards", "said"),
    [
        ([], "boards is empty"),
        ({}, "boards is empty"),
        ("classic", "must be a mapping, or several boards"),
        ([BOARD, BOARD.with_friction(0.2)], "two boards are called 'triangle-8'"),
    ],
)
def test_a_sweep_over_no_boards_is_refused(boards: Any, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        sweep(boards, 5)
