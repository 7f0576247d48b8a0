"""The photon of problem 2 in ball arithmetic: any number of digits, with proof.

It uses the certified solver's flights and impacts. The mirrors' radius is exactly 1/3, which no
float64 can represent.
"""

import time
from dataclasses import dataclass, replace

from flint import arb

from benchmarks.billiards import Billiard
from benchmarks.literature.siam import MIRRORS, TIME
from plinko.engine.certified.balls import ONE, ZERO, Proof, UndecidedError, precision
from plinko.engine.certified.flight import Flight, State
from plinko.engine.certified.impulse import bounce
from plinko.engine.certified.next_impact import BOUNCED, Touch, Touched, next_impact
from plinko.engine.certified.scene import Scene
from plinko.engine.certified.surfaces import Circle, Pair
from plinko.engine.constants import KIND_PEG

ELASTIC = Pair(ONE, ZERO)
NO_BOARD = Billiard().fields
"""An empty plane without gravity, to which the mirrors are added."""


@dataclass(frozen=True)
class Certified:
    """The proven digits of the distance, and the work that the proof took."""

    text: str
    digits: int  # the requested digits after the point, if all are proven, otherwise 0
    error: float  # bound; 0 if it is too small for float64
    bits: int
    comparisons: int
    reflections: int
    seconds: float


def with_digits(digits: int) -> Certified:
    """The distance at t = 10, proven to `digits` digits by doubling the precision as needed."""
    start = time.perf_counter()
    bits = 64
    while True:
        found = with_bits(bits, digits)
        if found is not None and found.digits >= digits:
            taken = time.perf_counter() - start
            return replace(found, seconds=taken)
        bits *= 2


def with_bits(bits: int, digits: int) -> Certified | None:
    """The distance as proven with `bits` of precision; None if a comparison is undecided.

    The text has at most `digits` digits, and fewer if fewer are proven.
    """
    start = time.perf_counter()
    proof = Proof()
    with precision(bits):
        try:
            place, reflections = _fly(proof)
        except UndecidedError:
            return None
        distance = (place.x * place.x + place.y * place.y).sqrt()
        text = distance.str(digits, radius=False)
        proven = digits if distance.rad() < arb(10) ** -digits / 2 else 0
        error = float(distance.rad())
    taken = time.perf_counter() - start
    return Certified(text, proven, error, bits, proof.comparisons, reflections, taken)


def _mirrors() -> Scene:
    """The mirrors at the current precision."""
    places = [(x, y) for x in MIRRORS for y in MIRRORS]
    return Scene(
        NO_BOARD,
        [
            Circle(arb(x), arb(y), ONE / 3, KIND_PEG, i, i, ELASTIC)
            for i, (x, y) in enumerate(places)
        ],
    )


def _fly(proof: Proof) -> tuple[State, int]:
    """The photon's state at t = 10 and its reflections; UndecidedError if precision is too low."""
    scene = _mirrors()
    state = State(ZERO, ONE / 2, ONE / 10, ONE, ZERO, ZERO)
    touched: Touched = {}
    reflections = 0
    while True:
        flight = Flight(scene, state)
        hit = next_impact(scene, flight, touched, proof)
        left = arb(TIME) - state.t
        if hit is None or proof.is_positive(hit.time - left, "whether time ends first"):
            return flight.at(left), reflections
        state = flight.at(hit.time)
        (mirror,) = hit.surfaces
        nx, ny = mirror.normal(state.x, state.y)
        approach, along = state.vx * nx + state.vy * ny, state.vy * nx - state.vx * ny
        after = bounce(approach, along, ZERO, mirror.pair, scene.radius, proof)
        x, y = mirror.at_contact(state.x, state.y, nx, ny)
        vx, vy = after.off * nx - after.along * ny, after.off * ny + after.along * nx
        state = State(state.t, x, y, vx, vy, ZERO)
        touched = {mirror: Touch(BOUNCED, after.off)}
        reflections += 1
