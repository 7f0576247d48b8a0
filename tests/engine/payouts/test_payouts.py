"""Presets return what they state from each of their aims; a table can be solved for any chances."""

from dataclasses import replace

import numpy as np
import pytest

from plinko.engine import Board, ParameterError, drop_many, preset_names
from plinko.engine.board import payouts
from plinko.engine.board.presets import HOUSE, VARIANTS, payouts_of, plain_name
from plinko.engine.board.worlds import WORLDS
from plinko.engine.payouts import table
from plinko.engine.payouts.landings import (
    Landings,
    aims_of,
    is_mirrored,
    joined,
    more,
    none_after,
    none_yet,
)
from plinko.engine.payouts.listing import listed, takes_stakes
from plinko.engine.payouts.odds import odds_of
from plinko.engine.payouts.record import (
    LEAST,
    LEAST_AIMED,
    LEAST_WORLD,
    odds_of_record,
    shipped,
)
from plinko.engine.payouts.solve import risk_of, solve_payouts, table_for
from tests.long import tries

PLAYED = tuple(name for name in preset_names() if name != "galton")
OWN = (0.988, 0.992)
WORLD = (0.985, 0.995)
AIMED = (0.95, 0.992)
SURE = 5.0  # standard deviations; one sample in a million deviates more


def test_by_recorded_landings_a_preset_returns_what_it_states() -> None:
    """From each of its aims. The recorded drops are not those for which the table was solved."""
    for name in PLAYED:
        board = Board.preset(name)
        own, *others = odds_of_record(board)
        house = listed(name).world == HOUSE
        for odds, (least, most) in (
            (own, OWN if house else WORLD),
            *((each, AIMED) for each in others),
        ):
            assert least <= odds.returned <= most, (name, odds.aim)
        assert own.drops >= (LEAST if house else LEAST_WORLD), name
        assert all(each.drops >= LEAST_AIMED for each in others), name
        found = shipped()[plain_name(name)].all()
        assert tuple(each.aim for each in found) == aims_of(board), name
        assert {len(each.histogram) for each in found} == {board.bins.count}, name
        assert sum(each.unsettled_count for each in found) == 0, name


@pytest.mark.parametrize("name", [name for name in PLAYED if plain_name(name) == name])
def test_drops_of_other_seeds_land_as_those_of_record_did(name: str) -> None:
    """Pearson's chi-square test of two samples from the board's own start."""
    count = tries(2_000, 1_000_000)
    first = 10**12
    there = np.array(shipped()[name].all()[0].histogram)
    here = drop_many(name, range(first, first + count)).histogram
    few = (there + here) * count / there.sum() < 5.0
    pairs = np.array([there[~few], here[~few]])
    pairs = np.column_stack((pairs, [there[few].sum(), here[few].sum()]))
    pairs = pairs[:, pairs.sum(axis=0) > 0]
    expected = np.outer(pairs.sum(axis=1), pairs.sum(axis=0)) / pairs.sum()
    chi_square = float(((pairs - expected) ** 2 / expected).sum())
    freedom = pairs.shape[1] - 1
    assert chi_square < freedom + SURE * np.sqrt(2.0 * freedom) + SURE**2


@pytest.mark.parametrize("name", [f"{world}-{rows}" for world in WORLDS for rows in (8, 11, 16)])
def test_a_world_s_tables_follow_from_the_drops_that_chose_them(name: str) -> None:
    chose, *_ = shipped()[name].blocks
    for risk in payouts.RISKS:
        table_name = VARIANTS[name]._replace(risk=risk).name
        assert table_for(Board.preset(name), chose, 0.99, risk) == payouts_of(table_name)


def test_a_table_takes_stakes_if_its_counted_return_is_right() -> None:
    assert {name for name in preset_names() if not listed(name).stakes} == {"galton"}
    form = Board.preset("moon-16").to_dict()
    assert takes_stakes(Board.from_json(form))
    assert not takes_stakes(Board.from_json({**form, "gravity": 9.81}))
    assert not takes_stakes(Board.from_json({**form, "bins": {**form["bins"], "y": 1.65}}))


@pytest.mark.parametrize(
    "name", ["triangle-9-low", "classic", "galton", "moon-8", "rubber-16-high"]
)
def test_a_preset_s_row_in_a_list_is_what_its_board_says(name: str) -> None:
    row, board = listed(name), Board.preset(name)
    assert (row.name, row.digest, row.bins) == (name, board.digest, board.bins.count)
    assert (row.pegs, row.multipliers) == (len(board.pegs), board.bins.multipliers)
    assert row.size == (board.width, board.height)
    assert row.returned == next((each.returned for each in odds_of_record(board)), None)


def test_galton_pays_the_same_whatever_happens() -> None:
    assert set(Board.preset("galton").bins.multipliers) == {0.99}


def test_what_record_says_is_what_the_same_seeds_give() -> None:
    board = Board.preset("triangle-8")
    found = more(board, none_yet(board)[0], 500)
    assert found == more(board, more(board, none_yet(board)[0], 200), 300)
    assert found.drops == 500
    assert list(found.histogram) == drop_many(board, range(500)).histogram.tolist()


def test_landings_are_joined_where_their_seeds_are_consecutive() -> None:
    first, next_ones = Landings(0.1, (3, 4), 1), Landings(0.1, (1, 0), 0, 8)
    assert joined(first, next_ones) == Landings(0.1, (4, 4), 1)
    for other in (Landings(0.1, (1, 0), 0, 7), Landings(None, (1, 0), 0, 8)):
        with pytest.raises(ParameterError, match=r"do not follow those before 8 at aim 0\.1"):
            joined(first, other)


def test_presets_are_symmetric_a_board_with_a_moved_peg_is_not() -> None:
    assert all(is_mirrored(Board.preset(name)) for name in ("triangle-9", "classic", "galton"))
    form = Board.preset("triangle-9").to_dict()
    form["pegs"][3]["x"] += 0.01
    assert not is_mirrored(Board.from_json(form))


def test_odds_are_those_of_the_chances() -> None:
    board = Board.from_json({"bins": {"multipliers": [3, 0.5, 3]}})
    landings = none_yet(board)[0]
    odds = odds_of(Landings(landings.aim, (10, 70, 15), 5), board.bins.multipliers)
    assert odds.returned == pytest.approx(0.25 * 3 + 0.7 * 0.5 + 0.05)
    assert odds.hit_rate == pytest.approx(0.30)
    assert odds.volatility**2 == pytest.approx(0.25 * 9 + 0.7 * 0.25 + 0.05 - odds.returned**2)
    assert odds.awards == ((3.0, 0.25), (0.5, 0.7))


@pytest.mark.parametrize("risk", payouts.RISKS)
@pytest.mark.parametrize("rows", [8, 11, 16])
def test_binomial_chances_give_nearly_the_reference_top_award(
    rows: int, risk: payouts.Risk
) -> None:
    chances = np.array([[float(w) for w in _ways(rows)]]) / 2.0**rows
    pays = table.solve(chances, risk, table.Bounds(), mirrored=True)
    known = table.reference(rows, risk)
    assert chances[0] @ pays == pytest.approx(0.99, abs=table.NEAR)
    assert pays == pays[::-1]
    assert pays[0] == max(pays) == pytest.approx(known[0], rel=0.2)


def _ways(rows: int) -> list[int]:
    ways = [1]
    for k in range(rows):
        ways.append(ways[-1] * (rows - k) // (k + 1))
    return ways


def test_a_board_of_one_s_own_gets_a_table_too() -> None:
    form = Board.preset("triangle-8").to_dict() | {"name": "mine", "drag": 2.0}
    board = Board.from_json(form)
    told: list[tuple[int, int]] = []
    found = solve_payouts(
        board, risk="low", drops=2_000, threads=1, progress=lambda *now: told.append(now)
    )
    chose = more(board, none_yet(board)[0], 2_000)
    assert odds_of(chose, found.multipliers).returned == pytest.approx(0.99, abs=table.NEAR)
    assert found.landings == (more(board, none_after(chose), 2_000),)
    assert found.odds == (odds_of(found.landings[0], found.multipliers),)
    assert found.least is found.odds[0]
    assert found.chosen_by == found.drops == 2_000
    assert told == [(2_000, 4_000), (4_000, 4_000)]
    assert all(pays in table.LADDER for pays in found.multipliers)
    assert found.to_dict()["aims"][0]["awards"][0]["multiplier"] == max(found.multipliers)


def test_what_cannot_be_solved_is_refused_and_named() -> None:
    with pytest.raises(ParameterError, match="risk is 'huge': it must be low, medium or high"):
        risk_of("huge")
    with pytest.raises(ParameterError, match="return 2 is not from"):
        solve_payouts("triangle-8", returned=2)
    sure = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    with pytest.raises(ParameterError, match="no table of risk low returns"):
        table.solve(sure, "low", table.Bounds(0.99, 0.9899, 0.98995), mirrored=False)


def test_a_changed_board_has_no_odds_of_record() -> None:
    form = Board.preset("triangle-8").to_dict()
    assert len(odds_of_record(Board.from_json(form))) == 1
    assert odds_of_record(Board.from_json(form | {"drag": 2.0})) == ()


def test_a_table_chosen_by_too_few_drops_names_its_guessed_bins() -> None:
    few = solve_payouts("triangle-8", drops=300)
    rare, *_ = few.warnings
    assert "balls are too few to know how often bins 0, 1, 2, 6, 7, 8 are hit" in rare
    assert few.to_dict()["warnings"] == list(few.warnings)
    assert few.to_dict()["rare_bins"] == [0, 1, 2, 6, 7, 8]


def test_a_table_that_falls_towards_a_side_says_so() -> None:
    found = solve_payouts("triangle-8", drops=20_000)
    assert found.warnings == ()
    for pays, falling in (
        ((9.0, 3.0, 2.0, 1.0, 0.1, 1.0, 2.0, 3.0, 9.0), ()),
        ((2.0, 3.0, 2.0, 1.0, 0.1, 1.0, 2.0, 3.0, 9.0), (0,)),
        ((9.0, 3.0, 2.0, 1.0, 0.1, 1.0, 0.9, 3.0, 2.0), (6, 8)),
    ):
        board = replace(found.board, bins=replace(found.board.bins, multipliers=pays))
        judged = replace(found, board=board)
        assert judged.falling_bins == falling
        said = f"bins {', '.join(map(str, falling))} pay less than their neighbours"
        assert (said in "".join(judged.warnings)) == bool(falling)
