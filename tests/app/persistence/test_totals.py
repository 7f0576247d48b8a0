"""Stakes and payouts are counted once, by board and stake, and compared with expectation."""

from math import sqrt

import pytest

from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.statements import totals, writing
from plinko.app.persistence.statements.totals import Total, band
from plinko.app.rooms.records import BoardRow, DropRow, ResultRow, RoomRow, Write
from plinko.app.web.returns import DEVIATIONS, Returns, tolerance
from plinko.engine import Board
from plinko.engine.payouts.record import odds_of_record
from tests.kit.facts import new
from tests.kit.null_ledger import NullLedger

BOARD = Board.preset("triangle-16-high")


def played(ball: int, stake: int, payout: int, **more: object) -> list[Write]:
    drop = DropRow(1, ball, 0, ball, stake=stake, aim=0.01 if more.get("aimed") else None)
    where = None if more.get("unsettled") else 3
    return [new(drop), ResultRow(1, ball, 9, where, 1.0, 1.0, 0.0, "d" * 64, None, payout)]


def story() -> list[Write]:
    return [
        BoardRow("b" * 64, "board", "{}"),
        RoomRow(1, "r", "b" * 64, "independent", True, 60, 1, 1.5, 2.5),
        *played(0, 100, 250),
        *played(1, 999, 0),
        *played(2, 99, 99),
        *played(3, 100, 40, aimed=True),
        *played(4, 0, 0),
        *played(5, 100, 100, unsettled=True),
    ]


SUMS = [
    Total("b" * 64, 10, False, 1, 99, 99.0**2, 99),
    Total("b" * 64, 100, False, 2, 1099, 100.0**2 + 999.0**2, 250),
    Total("b" * 64, 100, True, 1, 100, 100.0**2, 40),
]


def test_staked_plays_count_once_however_often_written(url: str) -> None:
    database = Database(url)
    database.open()
    with database.transaction() as connection:
        writing.apply(connection, story())
    with database.transaction() as connection:
        assert totals.read(connection) == SUMS
        writing.apply(connection, [row for row in story() if isinstance(row, ResultRow)])
        assert totals.read(connection) == SUMS
        writing.apply(connection, played(6, 100, 0))
        assert totals.read(connection)[1] == Total("b" * 64, 100, False, 3, 1199, 1018001.0, 250)
    database.close()


def test_stakes_are_grouped_by_powers_of_ten() -> None:
    assert [band(stake) for stake in (1, 9, 10, 999, 1000, 10**9)] == [1, 1, 10, 100, 1000, 10**9]


def test_the_tolerance_is_k_sigma_by_the_root_of_the_plays() -> None:
    many = Total(BOARD.digest, 1000, False, plays=400, staked=400_000, squares=4e8, paid=380_000)
    rounding = 400 / 400_000
    expected = pytest.approx(DEVIATIONS * 2.0 / sqrt(400) + rounding + 0.5)
    assert tolerance(many, 2.0, 0.5) == expected
    # One large stake among many small ones counts like a single play.
    rare = Total(BOARD.digest, 100, False, plays=101, staked=10_100, squares=1e8, paid=0)
    assert tolerance(rare, 2.0, 0.0) > DEVIATIONS * 2.0 * 0.99


def told(*found: Total) -> dict[tuple[str, str, str], float]:
    """The metrics of these totals, by name, board and size of stake."""
    returns = Returns(NullLedger(), found)
    return {
        (name, labels["board"], labels["stake"]): value
        for name, _, value, labels in returns.readings()
    }


def test_a_preset_s_return_is_shown_with_its_expectation() -> None:
    found = told(Total(BOARD.digest, 100, False, 100, 10_000, 1e6, 20_000))
    where = (BOARD.name, "100")
    (own, *_) = odds_of_record(BOARD)
    assert found["plinko_return", *where] == 2.0
    assert found["plinko_return_expected", *where] == own.returned
    assert found["plinko_return_tolerance", *where] == pytest.approx(
        4.0 * own.volatility / 10.0 + own.doubt + 0.01
    )
    assert found["plinko_plays_total", *where] == 100


def test_boards_of_players_share_a_label_and_are_not_judged() -> None:
    found = told(
        Total("a" * 64, 10, False, 1, 10, 100.0, 5), Total("b" * 64, 10, False, 2, 30, 500.0, 7)
    )
    assert found == {
        ("plinko_plays_total", "other", "10"): 3,
        ("plinko_staked_total", "other", "10"): 40,
        ("plinko_paid_total", "other", "10"): 12,
    }
