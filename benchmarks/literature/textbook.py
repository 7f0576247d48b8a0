"""Textbook formulas that the engine should meet up to rounding: orbits, falls, rolling, bounces.

Each formula is derived where it is used; the sources say where it is printed.
"""

from decimal import Decimal, localcontext
from math import hypot, sqrt

import numpy as np

from benchmarks.billiards import Billiard, path
from benchmarks.literature.finding import Finding, exact
from plinko.engine import Arena, ArenaSettings, StaticGeometry
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Peg, Wall
from plinko.engine.constants import KIND_CONTACT_BEGIN, KIND_CONTACT_END, KIND_WALL
from plinko.engine.drops.certainty import certainty_of
from plinko.engine.drops.trajectory import Trajectory
from plinko.engine.physics import body

G = 9.81

CHAOS_BOOK = "Cvitanović et al., ChaosBook, billiards: stability of a 2-cycle"
GOLDSTEIN = "Goldstein, Classical Mechanics, 2 (sphere on a sphere), with I = m R²/2 for a disc"


def orbit_multiplier(spacing: float, radius: float) -> Finding:
    """A ball that bounces to and fro between two discs of `radius`, their centres `spacing` apart.

    A neighbouring ray's offset grows in every bounce by a factor whose limit is
    R/a - 1 + (R/a) sqrt(1 - 2a/R), the larger root of L^2 - 2 (R/a - 1) L + 1 = 0.
    """
    half = 0.5 * spacing
    pegs = (Peg(0.0, -half, 0.5 * radius), Peg(0.0, half, 0.5 * radius))
    board = Billiard(pegs=pegs, ball=BallSpec(radius=0.5 * radius, restitution=1.0))
    bounces = 60
    gap = spacing - 2.0 * radius
    found = path(board, (0.0, 0.0), (0.0, 1.0), gap * (bounces + 0.25))
    growth = certainty_of(found).growth
    ratio = spacing / radius
    wanted = ratio - 1.0 + ratio * sqrt(1.0 - 2.0 / ratio)
    return exact(
        f"two discs, R/a = {ratio:g}: multiplier", wanted, float(growth[-1] / growth[-2]),
        CHAOS_BOOK,
    )  # fmt: skip


def slider_leaves(speed: float) -> Finding:
    """The angle at which a frictionless ball leaves a peg, started on its top with `speed`.

    u^2 = u0^2 + 2 g D (1 - cos), and the normal force vanishes when u^2 = g D cos:
    cos = (2 + u0^2 / g D) / 3.
    """
    wanted = (2.0 + speed * speed / (G * _DISTANCE)) / 3.0
    return exact(
        f"leaves a peg, no friction, u0 = {speed:g} m/s: cos θ", wanted,
        leaving_cosine(0.0, speed), GOLDSTEIN,
    )  # fmt: skip


def roller_leaves(friction: float, speed: float) -> Finding:
    """The same with friction: a ball that rolls until it leaves has cos = (4 + 3 u0^2/gD) / 7.

    With spin, 3/4 u^2 = 3/4 u0^2 + g D (1 - cos). A real ball slips just before it leaves, because
    the normal force goes to zero. The formula is therefore the limit of infinite friction.
    """
    wanted = (4.0 + 3.0 * speed * speed / (G * _DISTANCE)) / 7.0
    found = leaving_cosine(friction, speed)
    return Finding(
        f"leaves a peg, friction {friction:g}: cos θ", f"→ {wanted:.6f}", f"{found:.6f}",
        f"{found - wanted:+.1e}", GOLDSTEIN, found - wanted,
    )  # fmt: skip


_DISTANCE = 0.5
"""Sum of both radii, m."""


def leaving_cosine(friction: float, speed: float) -> float:
    """Cosine of the angle from the top at which a ball leaves a peg after rolling from its top."""
    radius = 0.1
    surface = Material(0.0, friction)
    board = Billiard(
        pegs=(Peg(0.0, 0.0, _DISTANCE - radius),),
        ball=BallSpec(radius=radius, restitution=0.0, friction=friction),
        material=surface,
        gravity=G,
    )
    found = path(board, (0.0, -_DISTANCE), (speed, 0.0), 10.0, spin=speed / radius)
    row = _first(found, KIND_CONTACT_END)
    return -float(found.events[row, 2]) / _DISTANCE


def falls_with_drag(drag: float, time: float) -> Finding:
    """Distance fallen with drag: (g/k) (t - (1 - exp(-k t)) / k), computed to 40 digits."""
    board = Billiard(gravity=G, drag=drag)
    found = float(path(board, (0.0, 0.0), (0.0, 0.0), time).end[body.Y])
    with localcontext() as context:
        context.prec = 40
        g, k, t = Decimal(G), Decimal(drag), Decimal(time)
        wanted = float(g / k * (t - (1 - (-k * t).exp()) / k))
    return exact(
        f"falls {time:g} s with drag {drag:g} 1/s: m", wanted, found,
        "Landau and Lifshitz, Mechanics: linear drag",
    )  # fmt: skip


def bounces_end(restitution: float, height: float) -> Finding:
    """The time at which bounces on a floor have died out: (1 + e) / (1 - e) sqrt(2 h / g).

    The engine ends the infinite sequence at a bounce slower than 1e-8 m/s. The remaining flights
    are the rest of a geometric series, 2 v / (g (1 - e)) with the speed v of that bounce, which is
    added here.
    """
    radius = 0.1
    board = Billiard(
        walls=(Wall(-1.0, height + radius, 1.0, height + radius),),
        ball=BallSpec(radius=radius, restitution=restitution),
        material=Material(restitution, 0.0),
        gravity=G,
    )
    found = path(board, (0.0, 0.0), (0.0, 0.0), 1000.0)
    last = max(np.flatnonzero(found.marks[: _first(found, KIND_CONTACT_BEGIN), 0] == KIND_WALL))
    speed = abs(float(found.events[last, 4]))
    time = float(found.events[last, 0]) + 2.0 * speed / (G * (1.0 - restitution))
    wanted = (1.0 + restitution) / (1.0 - restitution) * sqrt(2.0 * height / G)
    return exact(
        f"bounces with e = {restitution:g} end: s", wanted, time,
        "Falcon et al., Eur. Phys. J. B 3, 45 (1998)",
    )  # fmt: skip


def cradle(balls: int, speed: float) -> Finding:
    """A ball hits a row of equal touching balls, and the last one leaves with all of its speed.

    The engine has no special law for touching elastic balls; impacts one after another give this.
    """
    radius = 0.1
    arena = Arena(StaticGeometry(), ArenaSettings(gravity=0.0))
    arena.add(-1.0, 0.0, vx=speed, radius=radius, restitution=1.0, friction=0.0)
    for i in range(balls):
        arena.add(2.0 * radius * i, 0.0, radius=radius, restitution=1.0, friction=0.0)
    for _ in range(120):
        arena.step()
    velocities = arena.bodies["vx"]
    wanted = np.zeros(balls + 1)
    wanted[-1] = speed
    off = float(hypot(*(velocities - wanted).tolist()))
    return Finding(
        f"cradle of {balls}: speed of the last, m/s", f"{speed:g}", f"{velocities[-1]:.15g}",
        f"{off / speed:.0e}", "Herrmann and Schmälzle, Am. J. Phys. 49, 761 (1981)", off / speed,
    )  # fmt: skip


def _first(found: Trajectory, kind: int) -> int:
    return int(np.flatnonzero(found.marks[:, 0] == kind)[0])
