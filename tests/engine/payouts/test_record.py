"""The record of drops: a table is judged by drops that did not choose it; counting resumes."""

import json
from typing import Any

import pytest

from plinko.engine import Board, PlinkoError, drop_many
from plinko.engine.board.presets import HOUSE
from plinko.engine.payouts.landings import Landings, aims_of
from plinko.engine.payouts.listing import listed
from plinko.engine.payouts.odds import odds_of
from plinko.engine.payouts.record import (
    Counted,
    Record,
    counted_on,
    from_text,
    shipped,
    still_to_drop,
    to_text,
    wanted,
)

TABLES = ("triangle-8", "triangle-8-low", "triangle-8-high")
CHOSE = Landings(None, tuple(drop_many("triangle-8", range(300)).histogram.tolist()), 0)
JUDGE = Landings(None, (0,) * 9, 0, first=300)


def begun() -> Record:
    return {"triangle-8": Counted(((CHOSE,), (JUDGE,)), dict.fromkeys(TABLES, 1))}


def test_a_record_is_its_text() -> None:
    assert from_text(to_text(begun())) == begun()
    assert from_text(to_text(shipped())) == shipped()


AIM = CHOSE.to_dict()
DAMAGED: list[tuple[Any, str]] = [
    ([], "not a record of drops"),
    ({"triangle-99": {"blocks": [[AIM]], "chosen": {}}}, "triangle-99"),
    ({"triangle-8-low": {"blocks": [[AIM]], "chosen": {}}}, "triangle-8-low"),
    ({"triangle-8": []}, "Expected `object`"),
    ({"triangle-8": {"chosen": {}}}, "missing required field `blocks`"),
    ({"triangle-8": {"blocks": [[AIM]]}}, "missing required field `chosen`"),
    ({"triangle-8": {"blocks": [], "chosen": {}}}, "same aims with 9 bins"),
    ({"triangle-8": {"blocks": [[]], "chosen": {}}}, "same aims with 9 bins"),
    ({"triangle-8": {"blocks": [[AIM], [AIM, AIM]], "chosen": {}}}, "same aims with 9 bins"),
    ({"triangle-8": {"blocks": [5], "chosen": {}}}, r"got `int` - at .*blocks"),
    ({"triangle-8": {"blocks": [[AIM], [AIM]], "chosen": {}}}, "do not follow"),
    ({"triangle-8": {"blocks": [[AIM]], "chosen": {"classic": 0}}}, "'classic'"),
    ({"triangle-8": {"blocks": [[AIM]], "chosen": {"triangle-8": 1}}}, "chosen is 1"),
    ({"triangle-8": {"blocks": [["x"]], "chosen": {}}}, r"got `str` - at .*blocks"),
    *(
        ({"triangle-8": {"blocks": [[AIM | {name: value}]], "chosen": {}}}, rf"- at .*\.{name}")
        for name, value in (
            ("aim", "x"), ("first", -1), ("unsettled", 10**300), ("histogram", [1.5] * 9),
            ("histogram", None),
        )
    ),
]  # fmt: skip


@pytest.mark.parametrize(("form", "said"), DAMAGED)
def test_a_damaged_record_is_refused_by_its_place(form: Any, said: str) -> None:
    with pytest.raises(PlinkoError, match=said):
        from_text(json.dumps(form))


def test_a_board_s_blocks_are_consecutive_and_judges_come_last() -> None:
    for counted in shipped().values():
        assert {each.first for each in counted.blocks[0]} == {0}
        for earlier, later in zip(counted.blocks, counted.blocks[1:], strict=False):
            assert [each.next_seed for each in earlier] == [each.first for each in later]
        for name, blocks in counted.chosen.items():
            assert aims_of(Board.preset(name)) == tuple(each.aim for each in counted.fresh(name))
            chose = [sum(block[0].drops for block in counted.blocks[:blocks])]
            assert counted.fresh(name)[0].first == chose[0]


def test_fewer_than_one_in_a_million_aimed_drops_end_unsettled() -> None:
    """If none of n drops is unsettled, the rate is at 95 % at most 1 - 0.05^(1/n), about 3 / n."""
    aimed = [each for counted in shipped().values() for each in counted.all()[1:]]
    assert sum(each.unsettled_count for each in aimed) == 0
    assert 3.0 / sum(each.drops for each in aimed) < 1e-6
    for name, counted in shipped().items():
        own = counted.all()[0]
        assert own.unsettled_count == 0
        rare = 1e-6 if listed(name).world == HOUSE else 4e-6
        assert 3.0 / own.drops < rare, "of a drop at the middle, as the board's own start is"


def test_every_interval_of_record_is_as_narrow_as_it_should_be() -> None:
    """0.1 % at 95 % for a board's own start, 0.4 % in a world; `plinko odds --count` adds drops."""
    assert wanted(shipped()) == []


def test_counting_continues_with_the_next_seeds_and_keeps_counts() -> None:
    record = begun()
    want = wanted(record)[0]
    for drops in (40, 60):
        record = counted_on(from_text(to_text(record)), want, drops)
    counted = record["triangle-8"]
    assert counted.blocks[0] == (CHOSE,)
    assert counted.fresh("triangle-8")[0] == Landings(
        None, tuple(drop_many("triangle-8", range(300, 400)).histogram.tolist()), 0, first=300
    )
    assert (
        list(counted.all()[0].histogram) == drop_many("triangle-8", range(400)).histogram.tolist()
    )


def test_the_cheapest_interval_is_first_and_tables_share_drops() -> None:
    needs = wanted(begun())
    assert [each.table for each in needs] == ["triangle-8-low", "triangle-8", "triangle-8-high"]
    volatility = odds_of(CHOSE, Board.preset("triangle-8-high").bins.multipliers).volatility
    assert needs[-1].drops == pytest.approx((1.96 * volatility / 1e-3) ** 2, rel=1e-3)
    assert still_to_drop(needs) == needs[-1].drops


def test_what_is_known_well_enough_is_wanted_no_more() -> None:
    sure = Landings(None, tuple(1_000_000 * each for each in CHOSE.histogram), 0, first=300)
    record = {"triangle-8": begun()["triangle-8"].grown(0, sure)}
    assert wanted(record) == []


def test_only_later_seeds_judge_a_table_that_is_solved_again() -> None:
    counted = counted_on(begun(), wanted(begun())[0], 50)["triangle-8"]
    solved = counted.solved_again("triangle-8-high")
    assert solved.fresh("triangle-8-high") == (Landings(None, (0,) * 9, 0, first=350),)
    assert solved.fresh("triangle-8-low") == counted.fresh("triangle-8-low")
    assert solved.all() == counted.all()
    both = solved.solved_again("triangle-8")
    assert both.blocks == solved.blocks
    assert both.fresh("triangle-8") == solved.fresh("triangle-8-high")
