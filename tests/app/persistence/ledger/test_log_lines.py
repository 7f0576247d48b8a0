"""The log says what the ledger refuses, but no value of a row: a session's row has its secret."""

import asyncio
import dataclasses
import logging
from typing import Any

import pytest

from plinko.app.errors import LedgerError
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.rooms.records import BoardRow, FairSessionRow

SECRET = "5ec2e7" * 10
SESSION = FairSessionRow("s1", "show", "b" * 64, SECRET, "{}", "signature", 1.5)

REFUSED: dict[str, FairSessionRow] = {
    "twice": SESSION,
    "without a value": dataclasses.replace(SESSION, id="s2", statement=None),  # type: ignore[arg-type]
    "not a number": dataclasses.replace(SESSION, id="s3", opened=SECRET),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("row", REFUSED.values(), ids=REFUSED)
def test_a_refused_row_is_logged_by_its_kind(
    url: str, row: FairSessionRow, caplog: pytest.LogCaptureFixture
) -> None:
    async def scene() -> str:
        ledger = Ledger(Database(url), period=0.0, patience=5.0)
        ledger.open()
        ledger.start()
        try:
            await ledger.commit(BoardRow("b" * 64, "board", "{}"), SESSION)
            with pytest.raises(LedgerError) as refused:
                await ledger.commit(row)
            return str(refused.value)
        finally:
            await ledger.close()

    with caplog.at_level(logging.INFO, logger="plinko"):
        why = asyncio.run(scene())
    lines = [each.getMessage() for each in caplog.records]
    rejected = [each for each in lines if "rejects 1 FairSessionRow: " in each]
    assert rejected or row is REFUSED["not a number"], "SQLite gets no statement for that one"
    whole = "\n".join([why, caplog.text, *lines])
    assert [value for value in secrets_of(row) if value in whole] == []


def secrets_of(row: FairSessionRow) -> list[Any]:
    return [row.server_seed, row.signature]
