"""The payout tables are the reference game's, symmetric, and fair to a few tenths of a percent."""

from math import comb

import pytest

from engine.board import payouts

# Against the binomial, the tables of the 27 boards return 98.9 % to 99.2 %.
RETURN, TOLERANCE = 0.99, 0.002


def binomial_return(rows: int, risk: payouts.Risk) -> float:
    """Mean multiplier if each row sends a ball left or right with equal chance."""
    table = payouts.multipliers(rows, risk)
    return sum(comb(rows, k) * m for k, m in enumerate(table)) / float(2**rows)


@pytest.mark.parametrize("risk", payouts.HALF_TABLES)
@pytest.mark.parametrize("rows", payouts.ROWS)
def test_a_table_has_a_value_for_each_bin_the_same_from_either_side(
    rows: int, risk: payouts.Risk
) -> None:
    table = payouts.multipliers(rows, risk)
    assert len(table) == rows + 1
    assert table == table[::-1]
    assert table[0] == max(table)
    assert table[rows // 2] == min(table)


@pytest.mark.parametrize("risk", payouts.HALF_TABLES)
@pytest.mark.parametrize("rows", payouts.ROWS)
def test_a_table_returns_about_99_percent_against_the_binomial(
    rows: int, risk: payouts.Risk
) -> None:
    assert abs(binomial_return(rows, risk) - RETURN) <= TOLERANCE


def test_boards_with_an_even_number_of_bins_have_the_middle_value_twice() -> None:
    assert payouts.multipliers(8, "low") == (5.6, 2.1, 1.1, 1.0, 0.5, 1.0, 1.1, 2.1, 5.6)
    assert payouts.multipliers(9, "high") == (43, 7, 2, 0.6, 0.2, 0.2, 0.6, 2, 7, 43)


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
