"""The growth of a ledger is that of its tables."""

from pathlib import Path

import pytest

from benchmarks.harness.effort import Effort
from benchmarks.scale import ledger


@pytest.mark.parametrize("kind", [ledger.PLAIN, ledger.STAKED])
def test_a_ledger_grows_by_what_its_tables_grow(kind: str, tmp_path: Path) -> None:
    found = ledger.grown(f"sqlite:///{tmp_path / 'bench.db'}", kind, 2_000, Effort(quick=True))
    total = found.pop("")
    assert total == pytest.approx(sum(found.values()))
    assert found["drops"] > 0 < found["results"]
    assert (found["receipts"] > 0) == (kind == ledger.STAKED)
