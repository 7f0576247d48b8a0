"""Encloses the first time at which a distance falls through zero, and proves that it is the first.

Where the distance is positive at a time s, so is, for a while, a parabola below it (`least_bend`).
The distance has no root before the parabola's, and the search goes on from there. As soon as the
distance is proven to fall over a whole interval at whose end it is negative, that interval has one
root, which is the first of all; an interval Newton step encloses it.
"""

from typing import Protocol

from flint import arb, ctx

from plinko.engine.certified.balls import Proof, UndecidedError

_MAX_STEPS = 400
_MAX_POLISH = 40
_SHARES = (1.0 - 2.0**-20, 0.9, 0.5, 0.1, 0.01)
"""Shares of a step to the parabola's root, tried in turn: rounding may put a whole step past it."""


class Distance(Protocol):
    """A function of time with bounds of its second derivative; m and s."""

    def terms(self, s: arb) -> tuple[arb, arb, arb]:
        """Value, slope and second derivative at s; the last is 0 if the bounds do not need it."""

    def least_bend(self, bend: arb, h: arb) -> arb:
        """m such that the value at s + d is at least value + slope d + m d^2 / 2 for 0 <= d <= h.

        `bend` is the second derivative at s.
        """

    def most_bend(self, bend: arb, h: arb) -> arb:
        """An upper bound of the second derivative between s and s + h."""


def first_root(distance: Distance, start: float, end: float, proof: Proof, what: str) -> arb | None:
    """Enclosure of the first time in (start, end] at which `distance` falls through zero, or None.

    Raises UndecidedError, naming the surface `what`, if the distance is not proven positive at the
    start, or a later comparison stays open.
    """
    s, last = arb(start), arb(end)  # float64 is too coarse for the two roots of a graze
    for _ in range(_MAX_STEPS):
        value, slope, bend = distance.terms(s)
        proof.require_positive(value, f"whether the ball is outside of {what}")
        left = last - s
        m = distance.least_bend(bend, left)
        step = _parabola_root(value, slope, m)
        if not step < left and _stays_positive(value, slope, m, left):
            proof.count()
            return None
        to = _earlier(s + 2 * step, last)
        if _falls(distance, slope, bend, to - s):
            at_end = distance.terms(to)[0]
            if not proof.is_positive(at_end, f"whether {what} is hit before a stretch ends"):
                return _root_within(distance, s, _earlier(s + step, to), to, proof, what)
            following = to
        else:
            following = _root_free_until(s, _earlier(s + step, last), value, slope, m)
            proof.require(bool(following > s), f"whether {what} is hit")
        s = following
        if not s < last:
            return None
    raise UndecidedError(f"when {what} is hit")


def _earlier(a: arb, b: arb) -> arb:
    """The earlier of two times, as an exact number."""
    return a.mid() if a < b else b


def _root_free_until(s: arb, to: arb, value: arb, slope: arb, m: arb) -> arb:
    """A time, at most `to`, until which the parabola is proven positive; s if nothing is proven."""
    for share in _SHARES:
        following = (s + share * (to - s)).mid()
        if _stays_positive(value, slope, m, following - s):
            return following
    return s


def _parabola_root(value: arb, slope: arb, m: arb) -> arb:
    """An estimate of the first positive root of value + slope d + m d^2 / 2; inf without a root."""
    square = (slope * slope - 2 * m * value).mid()
    if square < 0:
        return arb.pos_inf()
    down = (square.sqrt() - slope).mid()
    return (2 * value / down).mid() if down > 0 else arb.pos_inf()


def _stays_positive(value: arb, slope: arb, m: arb, h: arb) -> bool:
    """Whether value + slope d + m d^2 / 2 is proven positive for 0 <= d <= h; value > 0."""
    if slope >= 0 and m >= 0:
        return True
    at_end = value + h * (slope + m * h / 2)
    if not at_end > 0:
        return False
    if m <= 0 or slope + m * h <= 0:
        return True
    return bool(slope * slope < 2 * m * value)


def _falls(distance: Distance, slope: arb, bend: arb, h: arb) -> bool:
    """Whether the distance is proven to fall for all of h, from a slope and second derivative."""
    return bool(slope < 0) and bool(slope + distance.most_bend(bend, h) * h < 0)


def _root_within(
    distance: Distance, low: arb, guess: arb, high: arb, proof: Proof, what: str
) -> arb:
    """The only root in an interval in which the distance falls, from positive to negative."""
    root = _polished(distance, guess, what)
    proof.require(bool(root > low) and bool(root <= high), f"when {what} is hit")
    return root


def _polished(distance: Distance, guess: arb, what: str) -> arb:
    """Newton steps from a guess, then one interval Newton step, which proves the enclosure.

    If t - value / slope, with the slope over all of the trial interval, lies inside that interval,
    it contains a root, and the only one. The trial is widened until that holds.
    """
    t = guess
    enough = arb(2) ** (-ctx.prec // 2)
    for _ in range(_MAX_POLISH):
        value, slope, _ = distance.terms(t)
        if not slope < 0:
            raise UndecidedError(f"when {what} is hit")
        change = (value / slope).mid()
        t = (t - change).mid()
        if abs(change) < enough * (1 + abs(t)):
            break
    value, slope, _ = distance.terms(t)
    radius = 3 * abs(value / slope).upper() + arb(2) ** -ctx.prec
    for _ in range(8):
        trial = t + arb(0, radius)
        slope = distance.terms(trial)[1]
        if slope < 0:
            enclosure = t - value / slope
            if trial.contains_interior(enclosure):
                return enclosure
        radius = 8 * radius
    raise UndecidedError(f"when {what} is hit")
