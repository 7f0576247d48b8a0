"""The first time at which a distance falls through zero, with proof that there is none before.

From a time s where the distance is positive, a parabola that lies below it (`least_bend`) is
positive up to some time: there the search goes on. Once the distance falls everywhere around the
root, that root is the first, and interval Newton encloses it.
"""

from typing import Protocol

from flint import arb, ctx

from engine.certified.balls import Proof, UndecidedError

_MAX_STEPS = 400
_MAX_POLISH = 40
_SHARES = (1.0 - 2.0**-20, 0.9, 0.5, 0.1, 0.01)
"""Of a step towards the root, tried in turn: rounding may carry it too far."""


class Distance(Protocol):
    """A function of time with bounds of its second derivative."""

    def terms(self, s: arb) -> tuple[arb, arb, arb]:
        """Value, slope and second derivative (if `least_bend` needs it) at s."""

    def least_bend(self, bend: arb, h: arb) -> arb:
        """m such that the value at s + d is at least value + slope d + m d^2 / 2, d <= h."""

    def most_bend(self, bend: arb, h: arb) -> arb:
        """At least the second derivative between s and s + h."""


def first_root(distance: Distance, start: float, end: float, proof: Proof, what: str) -> arb | None:
    """Enclosure of the first time in (start, end] at which `distance` falls through zero, or None.

    Raises UndecidedError, naming `what`, unless it is positive at the start and all is proven.
    """
    s, last = arb(start), arb(end)  # float64 is too coarse for the two roots of a graze
    for _ in range(_MAX_STEPS):
        value, slope, bend = distance.terms(s)
        proof.require(bool(value > 0), f"whether the ball is outside of {what}")
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
    """A time, at most `to`, until which the parabola is positive, with proof; s if none is."""
    for share in _SHARES:
        following = (s + share * (to - s)).mid()
        if _stays_positive(value, slope, m, following - s):
            return following
    return s


def _parabola_root(value: arb, slope: arb, m: arb) -> arb:
    """About the first positive root of value + slope d + m d^2 / 2, infinite if there is none."""
    square = (slope * slope - 2 * m * value).mid()
    if square < 0:
        return arb.pos_inf()
    down = (square.sqrt() - slope).mid()
    return (2 * value / down).mid() if down > 0 else arb.pos_inf()


def _stays_positive(value: arb, slope: arb, m: arb, h: arb) -> bool:
    """Whether value + slope d + m d^2 / 2 > 0 for all d from 0 to h, with proof; value > 0."""
    if slope >= 0 and m >= 0:
        return True
    at_end = value + h * (slope + m * h / 2)
    if not at_end > 0:
        return False
    if m <= 0 or slope + m * h <= 0:
        return True
    return bool(slope * slope < 2 * m * value)


def _falls(distance: Distance, slope: arb, bend: arb, h: arb) -> bool:
    """Whether the distance falls for all of h from where it has this slope and bend."""
    return bool(slope < 0) and bool(slope + distance.most_bend(bend, h) * h < 0)


def _root_within(
    distance: Distance, low: arb, guess: arb, high: arb, proof: Proof, what: str
) -> arb:
    """The only root between two times of different signs, between which the distance falls."""
    root = _polished(distance, guess, what)
    proof.require(bool(root > low) and bool(root <= high), f"when {what} is hit")
    return root


def _polished(distance: Distance, guess: arb, what: str) -> arb:
    """Newton's steps from a guess, then one of interval Newton, which proves the enclosure."""
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
