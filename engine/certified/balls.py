"""Ball arithmetic: a real number as a midpoint and a radius, and comparisons that are proven.

Each operation of python-flint's `arb` computes with `flint.ctx.prec` bits and returns a ball that
encloses the result for all numbers in its arguments. A comparison of two balls is true only if it
holds for all numbers in them. If neither x > 0 nor x <= 0 is true, the sign is unknown at this
precision; with more bits the balls shrink.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import RLock

from flint import arb, ctx

ZERO = arb(0)
ONE = arb(1)

_PRECISION = RLock()
"""python-flint has one precision for the whole process, so only one proof runs at a time."""


class UndecidedError(Exception):
    """The enclosures do not decide the comparison that `what` names.

    is_final: whether more bits would not decide it either.
    """

    def __init__(self, what: str, *, is_final: bool = False) -> None:
        super().__init__(what)
        self.what = what
        self.is_final = is_final


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Compute with `bits` bits within the context; other threads wait for it."""
    with _PRECISION:
        before = ctx.prec
        ctx.prec = bits
        try:
            yield
        finally:
            ctx.prec = before


class Proof:
    """The comparisons that decide one drop: their number, and the ties among them.

    A comparison beyond `most`, or after `patience` has returned False, raises UndecidedError.
    """

    def __init__(self, most: int = 1_000_000, patience: Callable[[], bool] = lambda: True) -> None:
        self.comparisons = 0
        self.ties: list[str] = []
        self._most = most
        self._patience = patience

    def count(self) -> None:
        """Count a comparison that the caller has proven."""
        self.comparisons += 1
        if self.comparisons > self._most:
            raise UndecidedError(f"more than {self._most} comparisons")
        self.check_time()

    def check_time(self) -> None:
        """Raises UndecidedError if the proof may take no longer."""
        if not self._patience():
            raise UndecidedError(f"what follows the first {self.comparisons} comparisons")

    def is_positive(self, x: arb, what: str) -> bool:
        """Whether x > 0. Raises UndecidedError(what) if the ball contains numbers of both kinds."""
        self.count()
        if x > 0:
            return True
        if x <= 0:
            return False
        raise UndecidedError(what)

    def require_positive(self, x: arb, what: str) -> None:
        """Count a comparison. Raises UndecidedError unless x > 0, a final one if x <= 0 is sure."""
        self.count()
        if not x > 0:
            raise UndecidedError(what, is_final=bool(x <= 0))

    def require(self, holds: bool, what: str) -> None:
        """Count a comparison. Raises UndecidedError(what) unless it is proven true."""
        self.count()
        if not holds:
            raise UndecidedError(what)


def upper(x: arb) -> float:
    """A float64 that is at least x; larger than need be, as the screen has a margin."""
    return float(x.upper()) * (1.0 + 1e-15) if x > 0 else float(x.upper()) * (1.0 - 1e-15)
