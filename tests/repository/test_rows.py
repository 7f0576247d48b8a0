"""Workers start with the tests that share servers and browsers, and each test runs once."""

import pytest

from tests.rows import DEAR, in_rows

NAMES = [
    *(f"tests/engine/test_{number}.py" for number in range(20)),
    *(f"{begin}test_{number}.py" for begins in DEAR for begin in begins for number in range(4)),
    *(f"tests/repository/test_{number}.py" for number in range(25)),
]


@pytest.mark.parametrize("workers", [2, 3, 4])
def test_no_test_is_lost_and_the_dear_ones_begin_the_rows(workers: int) -> None:
    ordered = in_rows(NAMES, NAMES, workers)
    assert sorted(ordered) == sorted(NAMES)
    begun = 0
    rows: list[list[str]] = []
    for left in range(workers, 0, -1):
        length = (len(NAMES) - begun) // left
        rows.append(ordered[begun : begun + length])
        begun += length
    together = [name for begins in DEAR for name in NAMES if name.startswith(begins)]
    for row in rows:
        dear = [name in together for name in row]
        assert dear == sorted(dear, reverse=True)
    for kind, begins in enumerate(DEAR):
        own = {name for name in NAMES if name.startswith(begins)}
        before = {name for each in DEAR[:kind] for name in NAMES if name.startswith(each)}
        assert own - before <= set(rows[kind % workers])
