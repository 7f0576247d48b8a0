"""In which order workers are given the tests: what shares servers and browsers comes first.

xdist deals tests out in rows, one for each worker, and who has done all of its own takes from the
end of another's. What is taken finds no fixture of the row it came from: another browser, another
cluster would start. So each row begins with tests that share something dear, and ends with those
that cost nothing but themselves.
"""

from collections.abc import Sequence
from typing import Final, TypeVar

T = TypeVar("T")

DEAR: Final = (
    ("tests/browser/table/",),
    ("tests/browser/",),
    ("tests/app/cluster/", "tests/app/persistence/"),
)
"""What belongs together, by how its tests' names begin; the first that fits counts."""


def in_rows(names: Sequence[str], tests: Sequence[T], workers: int) -> list[T]:
    """All of the tests, whose names are given, in the order for so many workers."""
    dear: list[list[T]] = [[] for _ in DEAR]
    cheap: list[T] = []
    for name, test in zip(names, tests, strict=True):
        kinds = (kind for kind, begins in enumerate(DEAR) if name.startswith(begins))
        kind = next(kinds, None)
        (cheap if kind is None else dear[kind]).append(test)
    ordered: list[T] = []
    for row in range(workers):
        # As xdist divides what is left by the workers that are left.
        length = (len(tests) - len(ordered)) // (workers - row)
        first = [test for group in dear[row::workers] for test in group]
        rest = max(0, length - len(first))
        ordered += first + cheap[:rest]
        del cheap[:rest]
    return ordered + cheap
