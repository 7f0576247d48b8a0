"""The payout tables of the triangles: symmetric, the rarest bin pays most, more with more risk."""

import pytest

from plinko.engine.board import payouts


@pytest.mark.parametrize("risk", payouts.HALF_TABLES)
@pytest.mark.parametrize("rows", payouts.ROWS)
def test_a_table_has_a_value_for_each_bin_and_is_symmetric(rows: int, risk: payouts.Risk) -> None:
    table = payouts.multipliers(rows, risk)
    assert len(table) == rows + 1
    assert table == table[::-1]
    assert table[0] == max(table)
    assert table[rows // 2] == min(table)


def test_an_even_number_of_bins_has_the_middle_value_twice() -> None:
    assert payouts.multipliers(8, "low").count(0.5) == 1
    assert payouts.multipliers(9, "high")[4:6] == (payouts.HALF_TABLES["high"][9][-1],) * 2


@pytest.mark.parametrize("rows", payouts.ROWS)
def test_more_risk_pays_more_at_the_edge_and_less_in_the_middle(rows: int) -> None:
    low, medium, high = (payouts.multipliers(rows, risk) for risk in payouts.HALF_TABLES)
    assert low[0] < medium[0] < high[0]
    middle = rows // 2
    assert low[middle] > medium[middle] >= high[middle]


def test_there_is_no_table_for_other_row_counts() -> None:
    rows = payouts.ROWS
    assert rows == tuple(range(8, 17))
    with pytest.raises(KeyError):
        payouts.multipliers(7, "low")
