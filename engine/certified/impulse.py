"""An impact in ball arithmetic, by the law of `engine/physics/impulse.py`."""

from typing import NamedTuple

from flint import arb

from plinko.engine.certified.balls import Proof
from plinko.engine.certified.surfaces import Pair


class Rebound(NamedTuple):
    """The velocity and spin right after an impact, and whether friction stopped the slip."""

    off: arb  # m/s, along the normal
    along: arb  # m/s, along (-n_y, n_x)
    omega: arb
    sticks: bool


def bounce(approach: arb, along: arb, omega: arb, pair: Pair, radius: arb, proof: Proof) -> Rebound:
    """The velocity (m/s) and spin (rad/s) after an impact at `approach` = v.n < 0.

    The normal impulse per unit mass is j_n = -(1 + e) v.n. The tangential one is -slip / 3, which
    stops the slip of a homogeneous disc, but at most mu j_n.
    """
    off = -pair.restitution * approach
    if pair.friction.is_zero():
        return Rebound(off, along, omega, sticks=False)
    slip = along - omega * radius
    limit = -pair.friction * (1 + pair.restitution) * approach
    if proof.is_positive(3 * limit - abs(slip), "whether friction stops the slip"):
        along = (2 * along + omega * radius) / 3  # along - slip / 3, where each counts once
        return Rebound(off, along, along / radius, sticks=True)
    push = -limit if proof.is_positive(slip, "which way the ball slips") else limit
    return Rebound(off, along + push, omega - 2 * push / radius, sticks=False)
