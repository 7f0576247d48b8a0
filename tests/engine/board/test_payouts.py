"""The payout tables of the house: symmetric, the rarest bin pays most, more with more risk."""

import pytest

from plinko.engine.board.payouts import RISKS, ROWS, Risk
from plinko.engine.board.presets import HOUSE, Variant, payouts_of


def table_of(rows: int, risk: Risk) -> tuple[float, ...]:
    return payouts_of(Variant(HOUSE, rows, risk).name)


@pytest.mark.parametrize("risk", RISKS)
@pytest.mark.parametrize("rows", ROWS)
def test_a_table_has_a_value_for_each_bin_and_is_symmetric(rows: int, risk: Risk) -> None:
    table = table_of(rows, risk)
    assert len(table) == rows + 1
    assert table == table[::-1]
    assert table[0] == max(table)
    assert table[rows // 2] == min(table)


def test_an_even_number_of_bins_has_the_middle_value_twice() -> None:
    assert table_of(8, "low").count(0.5) == 1
    assert table_of(9, "high").count(0.2) == 2


@pytest.mark.parametrize("rows", ROWS)
def test_more_risk_pays_more_at_the_edge_and_less_in_the_middle(rows: int) -> None:
    low, medium, high = (table_of(rows, risk) for risk in ("low", "medium", "high"))
    assert low[0] < medium[0] < high[0]
    middle = rows // 2
    assert low[middle] > medium[middle] >= high[middle]
