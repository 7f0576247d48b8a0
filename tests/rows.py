"""The order of tests for xdist's workers: tests that share servers and browsers come first.

xdist gives each worker a row of tests. A worker that has finished its row takes tests from the end
of another row. It does not have that row's fixtures, so it would have to start another browser or
another cluster. Each row therefore begins with tests that share expensive fixtures, and ends with
tests that need none.
"""

from collections.abc import Sequence
from typing import Final, TypeVar

T = TypeVar("T")

DEAR: Final = (
    (
        "tests/browser/table/test_t",
        "tests/browser/test_e",
        "tests/browser/test_r",
        "tests/browser/test_st",
    ),
    ("tests/browser/table/",),
    ("tests/browser/",),
    (
        "tests/app/cluster/",
        "tests/app/persistence/",
        "tests/repository/test_one_name",
        "tests/repository/test_wheel",
    ),
)
"""Groups of tests that share expensive fixtures, by the beginnings of their names.

The tests of pages take most of the time. Three browsers share them evenly.
"""


def in_rows(names: Sequence[str], tests: Sequence[T], workers: int) -> list[T]:
    """Return `tests`, with these `names`, in the order for `workers` workers."""
    dear: list[list[T]] = [[] for _ in DEAR]
    cheap: list[T] = []
    for name, test in zip(names, tests, strict=True):
        kinds = (kind for kind, begins in enumerate(DEAR) if name.startswith(begins))
        kind = next(kinds, None)
        (cheap if kind is None else dear[kind]).append(test)
    ordered: list[T] = []
    for row in range(workers):
        # xdist computes a row's length in the same way.
        length = (len(tests) - len(ordered)) // (workers - row)
        first = [test for group in dear[row::workers] for test in group]
        rest = max(0, length - len(first))
        ordered += first + cheap[:rest]
        del cheap[:rest]
    ordered += cheap
    assert {id(test) for test in ordered} == {id(test) for test in tests}, "no test is lost"
    assert len(ordered) == len(tests), "and none runs twice"
    return ordered
