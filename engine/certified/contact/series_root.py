"""Encloses the first time at which a Taylor series with a proven remainder falls through zero."""

from flint import arb, arb_poly, ctx

from plinko.engine.certified.balls import Proof, UndecidedError
from plinko.engine.certified.contact.series import Series

_MAX_DEPTH = 200
_MAX_POLISH = 40
_SCREEN = 1e-9  # relative margin, a million times float64's rounding


def first_fall(series: Series, skip: int, end: float, proof: Proof, what: str) -> arb | None:
    """Enclosure of the first time in (0, end] at which `series` falls through zero, or None.

    A known root of order `skip` at 0 is divided out. Raises UndecidedError(what) unless the
    quotient is proven positive at 0.
    """
    terms = series.terms[skip:]
    proof.count()
    if len(terms) == 0 or _is_plainly_positive(terms, series.tail, end):
        return None
    return _Search(terms, series.tail, end, what).run(proof)


def _is_plainly_positive(terms: list[arb], tail: arb, end: float) -> bool:
    """Whether the first term exceeds the sum of all others that may be negative.

    In double precision, to skip the search for most series.
    """
    least = float(terms[0].lower())
    total = abs(least)
    power = 1.0
    for term in terms[1:]:
        power *= end
        low = float(term.lower()) * power
        total += abs(low)
        least += min(low, 0.0)
    return least > _SCREEN * total + 2.0 * float(tail)


class _Search:
    """Bisection by bounds of the first two derivatives, then interval Newton.

    A piece is dropped if it is proven to have no fall, and halved if nothing is proven of it.
    """

    def __init__(self, terms: list[arb], tail: arb, end: float, what: str) -> None:
        self.value = arb_poly(terms)
        self.slope = self.value.derivative()
        self.tail, self.end, self.what = arb(0, tail), end, what
        bend = arb_poly([abs(term).upper() for term in self.slope.derivative().coeffs()])
        self.bend = bend(arb(end)).upper()

    def run(self, proof: Proof) -> arb | None:
        start = self.value(arb(0)) + self.tail
        proof.require_positive(start, self.what)
        pieces = [(0.0, self.end, 0)]
        while pieces:
            low, high, depth = pieces.pop()
            middle = 0.5 * (low + high)
            half = arb.max(arb(high) - arb(middle), arb(middle) - arb(low))
            value, slope = self.value(arb(middle)) + self.tail, self.slope(arb(middle))
            proof.count()
            turn = self.bend * half
            if value.contains(0) and value.rad() > (abs(slope) + turn) * half:
                # The enclosure's width exceeds the variation over the piece: halving cannot help.
                raise UndecidedError(self.what)
            if value - abs(slope) * half - turn * half / 2 > 0:
                continue
            if slope - turn > 0 and self._at(low) > 0:
                continue
            if slope + turn < 0 and self._at(low) > 0:
                at_high = self._at(high)
                if at_high > 0:
                    continue
                if at_high < 0:
                    return self._root(middle, low, high, proof)
            if depth == _MAX_DEPTH or not low < middle < high:
                raise UndecidedError(self.what)
            pieces += [(middle, high, depth + 1), (low, middle, depth + 1)]
        return None

    def _at(self, time: float) -> arb:
        return self.value(arb(time)) + self.tail

    def _root(self, guess: float, low: float, high: float, proof: Proof) -> arb:
        """Enclosure of the root between two times of different sign, where the polynomial falls.

        The remainder is only known to lie within the tail, so the interval holds every root that
        the series may have.
        """
        t = arb(guess)
        enough = arb(2) ** -(ctx.prec // 2)
        for _ in range(_MAX_POLISH):
            change = (self.value(t) / self.slope(t)).mid()
            t = arb.min(arb.max(t - change, arb(low)), arb(high)).mid()
            if abs(change) < enough:
                break
        value = self.value(t) + self.tail
        radius = 3 * abs(value / self.slope(t)).upper()
        for _ in range(8):
            trial = t + arb(0, radius)
            slope = self.slope(trial)
            if slope < 0:
                zero = t - value / slope
                if trial.contains_interior(zero):
                    proof.require(bool(zero > arb(low)) and bool(zero < arb(high)), self.what)
                    return zero
            radius = 8 * radius
        raise UndecidedError(self.what)
