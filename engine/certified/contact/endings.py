"""Finds what ends a stretch of rolling or sliding: each cause is the first fall of a series."""

from enum import Enum
from typing import NamedTuple

from flint import arb

from plinko.engine.certified.balls import ONE, ZERO, Proof
from plinko.engine.certified.contact.series import (
    ROLLING,
    SLIDING,
    Contact,
    Series,
    Stretch,
    linear,
    square,
)
from plinko.engine.certified.contact.series_root import first_fall
from plinko.engine.certified.surfaces import Circle, Face, Surface


class Cause(Enum):
    STEP = "the series end"
    LEAVES = "the normal force vanishes"
    CHANGES = "rolling becomes sliding, or sliding rolling"
    HITS = "another surface is touched"
    PASSES = "a wall's face ends, or its end becomes a face"
    LANDS = "the bins' line is crossed"


class Known(NamedTuple):
    """Quantities that the event before makes exactly zero at the start of a stretch.

    Their enclosures contain zero but do not prove it; the series' known roots are divided out.
    """

    slip_roots: int  # order of the slip's root: 0, 1, or 2 if a rolling ball has begun to slip
    joint: bool  # the ball has just passed from a face to a wall's end, or back
    touched: tuple[Surface, ...]  # other surfaces that the ball touches and moves away from


class Ending(NamedTuple):
    """The end of a stretch: its time in the stretch's unit, its cause, and the other surface."""

    share: arb
    cause: Cause
    slip_sign: int = 0
    surface: Surface | None = None


def first_ending(stretch: Stretch, known: Known, proof: Proof) -> Ending:
    """The first ending of a stretch, proven to be before all others; by default the series' end."""
    found = [
        *_force_endings(stretch, proof),
        *_slip_endings(stretch, known, proof),
        *_landings(stretch, proof),
        *_passages(stretch, known, proof),
        *_hits(stretch, known, proof),
    ]
    if not found:
        return Ending(arb(stretch.end), Cause.STEP)
    found.sort(key=lambda ending: float(ending.share))
    first = found[0]
    for other in found[1:]:
        what = f"whether {first.cause.value} or {other.cause.value} first"
        proof.require(bool(other.share > first.share), what)
    return first


def _force_endings(stretch: Stretch, proof: Proof) -> list[Ending]:
    what = f"whether the ball leaves {stretch.surface.name}"
    share = first_fall(stretch.force, 0, stretch.end, proof, what)
    return [] if share is None else [Ending(share, Cause.LEAVES)]


def _slip_endings(stretch: Stretch, known: Known, proof: Proof) -> list[Ending]:
    """Where the slip ends, or rolling needs more friction than Coulomb's law allows."""
    law, start = stretch.law, stretch.start
    if start.mode == SLIDING:
        way = arb(start.slip_sign)
        slip = linear(ZERO, (way, stretch.u), (-way * law.radius, stretch.omega))
        what = "whether the ball stops slipping"
        share = first_fall(slip, known.slip_roots, stretch.end, proof, what)
        return [] if share is None else [Ending(share, Cause.CHANGES)]
    if start.mode != ROLLING:
        return []
    found = []
    for sign in (1, -1):
        spare = linear(
            ZERO,
            (3 * law.friction, stretch.force),
            (-sign * law.gravity, stretch.nx),
            (sign * law.drag, stretch.u),
        )
        share = first_fall(spare, 0, stretch.end, proof, "whether the ball begins to slip")
        if share is not None:
            found.append(Ending(share, Cause.CHANGES, sign))
    return found


def _landings(stretch: Stretch, proof: Proof) -> list[Ending]:
    left = stretch.scene.bins_y - stretch.start.y
    if isinstance(stretch.surface, Circle):
        reach = stretch.surface.reach
        height = linear(stretch.scene.bins_y - stretch.surface.y, (-reach, stretch.ny))
    else:
        height = linear(left, (-stretch.start.nx, stretch.way))
    share = first_fall(height, 0, stretch.end, proof, "whether the ball lands")
    return [] if share is None else [Ending(share, Cause.LANDS)]


def _passages(stretch: Stretch, known: Known, proof: Proof) -> list[Ending]:
    """Where a face ends in a circle, or a wall's end continues as a face."""
    surface, start = stretch.surface, stretch.start
    what = f"whether the ball comes to the end of {surface.name}"
    found = []
    if isinstance(surface, Face):
        turn = 1 if start.nx * surface.ty - start.ny * surface.tx > 0 else -1
        foot = surface.along(start.x, start.y)
        for nth, end in enumerate(surface.ends):
            sign = turn if nth == 0 else -turn
            left = foot if nth == 0 else surface.length - foot
            distance = linear(left, (arb(sign), stretch.way))
            # A ball that has just passed one of the ends moves away from that one.
            here = known.joint and left.contains(0)
            share = first_fall(distance, 1 if here else 0, stretch.end, proof, what)
            if share is not None:
                found.append(Ending(share, Cause.PASSES, surface=end))
        return found
    for face, nth in stretch.scene.lines_at.get(surface, []):
        out = arb(-1 if nth == 0 else 1)
        outwards = linear(ZERO, (out * face.tx, stretch.nx), (out * face.ty, stretch.ny))
        if outwards.terms[0] < 0:
            continue  # on a peg, below the face: the ball would hit the other end of the wall first
        here = known.joint and outwards.terms[0].contains(0)
        share = first_fall(outwards, 1 if here else 0, stretch.end, proof, what)
        if share is not None and _faces(stretch, share, face, proof):
            found.append(Ending(share, Cause.PASSES, surface=face))
    return found


def _faces(stretch: Stretch, share: arb, face: Face, proof: Proof) -> bool:
    """Whether the contact normal points to the side of this face, not to the wall's other one."""
    at = stretch.at(share)
    return proof.is_positive(face.nx * at.nx + face.ny * at.ny, f"the side of {face.name}")


def _hits(stretch: Stretch, known: Known, proof: Proof) -> list[Ending]:
    start, end = stretch.start, stretch.at(arb(stretch.end))
    terms = [abs(term).upper() for term in stretch.way.terms]
    roam = sum((t * arb(stretch.end) ** i for i, t in enumerate(terms)), stretch.way.tail)
    a, b = (float(start.x), float(start.y)), (float(end.x), float(end.y))
    found = []
    for other in stretch.scene.screen.near(a, b, float(roam.upper())):
        if other is stretch.surface or _belongs(stretch, other):
            continue
        distance = _distance(stretch, other)
        if distance.terms[0] < 0 and isinstance(other, Face):
            _require_outside(start, other, distance.terms[0], proof)
            found += _way_out(stretch, other, distance, proof)
            continue
        share = _touch(stretch, other, distance, known, proof)
        if share is not None:
            found.append(Ending(share, Cause.HITS, surface=other))
    return found


def _require_outside(start: Contact, face: Face, distance: arb, proof: Proof) -> None:
    """Prove that a ball behind a face's line is on the wall's other side, or past one of its ends.

    `distance` is the ball's from the face.
    """
    along = face.along(start.x, start.y)
    is_past = bool(along < 0) or bool(along > face.length)
    is_behind = bool(distance < -face.reach)
    proof.require(is_past or is_behind, f"whether the ball is outside of {face.name}")


def _way_out(stretch: Stretch, face: Face, distance: Series, proof: Proof) -> list[Ending]:
    """End the stretch where a ball behind a face's infinite line, past the wall, comes out.

    The search needs a distance that is positive at the start; a new stretch begins with one.
    """
    inside = linear(ZERO, (-ONE, distance))
    what = f"whether the ball crosses the line of {face.name}"
    share = first_fall(inside, 0, stretch.end, proof, what)
    if share is None:
        return []
    return [Ending(share.upper() * (1 + arb(2) ** -30), Cause.STEP)]


def _belongs(stretch: Stretch, other: Surface) -> bool:
    """Whether the ball passes `other` or passes onto it without an impact."""
    surface = stretch.surface
    if isinstance(surface, Face):
        if isinstance(other, Face):
            return other.rank == surface.rank
        return stretch.scene.are_flush(surface, other)
    return any(face is other for face, _ in stretch.scene.lines_at.get(surface, []))


def _touch(
    stretch: Stretch, other: Surface, distance: Series, known: Known, proof: Proof
) -> arb | None:
    """When the ball touches `other`, or None."""
    what = f"whether the ball on {stretch.surface.name} hits {other.name}"
    start, roots = stretch.start, 0
    touches = isinstance(other, Circle) and other.is_touched(start.x, start.y, distance.terms[0])
    if touches and proof.is_positive(-distance.terms[1], what):
        return ZERO
    if touches or other in known.touched:
        roots = 2 if start.u.is_zero() else 1
    share = first_fall(distance, roots, stretch.end, proof, what)
    if share is None or isinstance(other, Circle):
        return share
    at = stretch.at(share)
    along = other.along(at.x, at.y)
    inside = proof.is_positive(along, what) and proof.is_positive(other.length - along, what)
    return share if inside else None


def _distance(stretch: Stretch, other: Surface) -> Series:
    """The distance to `other` in the units of `CircleDistance` (m^2) or `LineDistance` (m)."""
    surface, start = stretch.surface, stretch.start
    if isinstance(other, Circle):
        if isinstance(surface, Circle):
            px, py = surface.x - other.x, surface.y - other.y
            apart = px * px + py * py + surface.reach**2 - other.reach**2
            twice = 2 * surface.reach
            return linear(apart, (twice * px, stretch.nx), (twice * py, stretch.ny))
        dx, dy = start.x - other.x, start.y - other.y
        apart = dx * dx + dy * dy - other.reach**2
        along = 2 * (dy * start.nx - dx * start.ny)
        return linear(apart, (along, stretch.way), (ONE, square(stretch.way, stretch.end)))
    if isinstance(surface, Circle):
        px, py = surface.x - other.x, surface.y - other.y
        apart = px * other.nx + py * other.ny - other.reach
        reach = surface.reach
        return linear(apart, (reach * other.nx, stretch.nx), (reach * other.ny, stretch.ny))
    dx, dy = start.x - other.x, start.y - other.y
    gap = dx * other.nx + dy * other.ny - other.reach
    return linear(gap, (other.ny * start.nx - other.nx * start.ny, stretch.way))
