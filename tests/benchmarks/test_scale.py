"""docs/scale.md is computed only from recorded figures."""

from contextlib import nullcontext
from dataclasses import replace

import pytest

from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.recorded import Recorded
from benchmarks.harness.report import Table
from benchmarks.scale import estimates, units
from benchmarks.scale.estimates import Units, processes_for, tables
from benchmarks.serving import relays
from benchmarks.serving.streams import FALL
from plinko.app.listening import MAX_CONNECTIONS
from plinko.engine.batches.hashes import BlockHashes
from plinko.engine.drops.digest import BLOCK

COST = Units(
    streams={"seeds": (10_000.0, 1_000.0, 10.0)},
    ticks={1: 1e-4},
    room_bytes={0: 1e4, 1: 2e4},
    drop=1e-4,
    mark=1e-5,
    row=300.0,
    client=5e4,
    server=2e8,
    rate=50_000.0,
)


def cells(table: Table, row: str) -> dict[str, str]:
    """The cells of the row with this first cell, by column."""
    (found,) = (each for each in table.rows if each[0] == row)
    return dict(zip(table.columns, found, strict=True))


def test_spectators_are_cores_processes_and_bytes() -> None:
    _, spectators, *_ = tables(COST)
    found = cells(spectators, "seeds")
    assert found["cores"] == "100"
    assert found["processes"] == "200", "half a core each"
    assert (found["memory"], found["sent"]) == ("50.0 GB", "1.00 GB/s")
    assert found["messages a second"] == "10,000,000"
    # If a core serves more clients than a process may have connections, the connections decide.
    most = MAX_CONNECTIONS
    assert processes_for(10 * most, 1e9) == 10


def test_streams_that_are_not_recorded_are_left_out() -> None:
    titles = [table.title for table in tables(replace(COST, streams={}))]
    assert len(titles) == 4
    assert not any("spectators" in title for title in titles)


def test_relays_are_beside_the_streams_once_they_are_recorded() -> None:
    cost = replace(COST, relayed=(20_000.0, 500.0, 10.0))
    costs, spectators, *_ = tables(cost)
    assert cells(costs, relays.SERVED)["measured"] == "20,000"
    found = cells(spectators, "seeds, over relays")
    assert (found["cores"], found["processes"], found["sent"]) == ("50", "100", "500 MB/s")
    shares = relays.Shares(5000, 0.1, 0.1, 0.25, 10.0, 500.0, 9, 11, 1e8)
    few = replace(shares, spectators=1000, relays=0.05)
    told = "\n\n".join(t.text() for t in (relays._shares([few, shares]), relays._each(few, shares)))
    assert estimates._relayed(Recorded(f"\n{told}\n")) == cost.relayed


def test_rooms_are_ticks_and_rows() -> None:
    _, _, rooms, _, first = tables(COST)
    found = cells(rooms, "1")
    assert found["cores for ticks"] == "600"
    drops = estimates.ROOMS / FALL
    assert found["drops a second"] == f"{drops:,.0f}"
    assert found["ledgers"] == f"{drops * 1e-4:,.1f}"
    at_most = {(row[0], row[1]): row[2] for row in first.rows}
    assert at_most["drops a second", "the ledger"] == "10,000"


def test_many_drops_keep_as_many_hashes_as_a_result_does() -> None:
    *_, drops, _ = tables(COST)
    found = cells(drops, "hashes that the result keeps")
    hashes = BlockHashes(-(-estimates.DROPS // BLOCK))
    assert found["value"] == f"{-(-hashes.blocks >> hashes.level):,}"
    assert cells(drops, "hours on 1,000 cores")["value"] == "5.6"


def test_a_number_is_read_from_the_table_of_its_title() -> None:
    text = "\n".join(
        Table(title, ["what", "ms", "share"], [["one", f"{value} (1 to 2)", "12.5%"]]).text()
        for title, value in (("First", "1,234.5"), ("Second", "7"))
    )
    page = Recorded(f"# Page\n\n{text}\n\nA note.\n")
    assert page.number("First", "one", "ms") == 1234.5
    assert page.number("Second", "one", "ms") == 7.0
    assert page.number("First", "one", "share") == pytest.approx(0.125)
    assert not page.has("Third")
    for title, row, column in (
        ("Third", "one", "ms"),
        ("First", "two", "ms"),
        ("First", "one", "s"),
    ):
        with pytest.raises(MissingError, match=row):
            page.number(title, row, column)


@pytest.mark.long("it measures")
def test_a_run_measures_what_the_page_reads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(units, "_postgresql", lambda: nullcontext(None))
    section = units.run(Effort(quick=True, rounds=1))
    page = Recorded(f"\n{section.text()}\n")
    assert page.number(units.ROOM, "8", "µs a tick") > 0.0
    sizes = [page.number(units.ROOM, str(balls), "bytes") for balls in (0, *units.BALLS)]
    assert sizes == sorted(sizes)
    for column in ("µs a drop", "µs a mark", "bytes a drop"):
        assert page.number(units.LEDGER, "SQLite", column) > 0.0
    assert section.absent, "PostgreSQL was not there"
