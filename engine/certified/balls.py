"""Ball arithmetic: a real number as a midpoint and a radius, and comparisons that are proven.

Each operation of python-flint's `arb` returns a ball that encloses every result that its arguments
allow, at `flint.ctx.prec` bits. A comparison of two balls is true only if it holds for all numbers
in them, so what is neither true nor false is not known yet: more bits may tell.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import RLock

from flint import arb, ctx

ZERO = arb(0)
ONE = arb(1)

_PRECISION = RLock()
"""python-flint's precision belongs to the whole process: one proof runs at a time."""


class UndecidedError(Exception):
    """A comparison that the enclosures leave open. `what` says which; more bits may decide it."""

    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.what = what


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Compute with `bits` bits meanwhile; other threads wait."""
    with _PRECISION:
        before = ctx.prec
        ctx.prec = bits
        try:
            yield
        finally:
            ctx.prec = before


class Proof:
    """The comparisons that one drop was decided by: how many, and the ties among them.

    `most` is how many may be asked for, `patience` whether there is time for one more;
    UndecidedError beyond them.
    """

    def __init__(self, most: int = 1_000_000, patience: Callable[[], bool] = lambda: True) -> None:
        self.comparisons = 0
        self.ties: list[str] = []
        self._most = most
        self._patience = patience

    def count(self) -> None:
        """One comparison more, whose outcome is proven by whoever asks."""
        self.comparisons += 1
        if self.comparisons > self._most:
            raise UndecidedError(f"more than {self._most} comparisons")
        if not self._patience():
            raise UndecidedError(f"what follows the first {self.comparisons} comparisons")

    def is_positive(self, x: arb, what: str) -> bool:
        """Whether x > 0; UndecidedError, naming `what` was asked, if its ball does not tell."""
        self.count()
        if x > 0:
            return True
        if x <= 0:
            return False
        raise UndecidedError(what)

    def require(self, holds: bool, what: str) -> None:
        """Count a comparison that came out true; UndecidedError if it did not."""
        self.count()
        if not holds:
            raise UndecidedError(what)


def upper(x: arb) -> float:
    """A float64 that is at least x, for screens that have a margin."""
    return float(x.upper()) * (1.0 + 1e-15) if x > 0 else float(x.upper()) * (1.0 - 1e-15)
