"""Position projection: removes overlap by moving balls, without changing their velocities.

This is post-stabilization (Cline and Pai, ICRA 2003). It treats one pair after the other at their
current places (non-linear Gauss-Seidel, as in Box2D 2's position solver).
"""

from math import sqrt

from plinko.engine.jit.decorator import kernel, lean_kernel
from plinko.engine.multibody.solver.layout import body
from plinko.engine.multibody.solver.layout.array_types import Floats
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.pair import NeighbourList
from plinko.engine.multibody.solver.layout.shape import StaticShapes
from plinko.engine.multibody.solver.narrow_phase import SPECULATIVE_GAP, separation

DEEP = 0.008
"""Overlap, in radii of the smaller ball, above which a pair is pushed apart at the end of a step.
It is below the 1 % that may be visible, and above what the time-of-impact loop normally leaves."""

LEAST_SHARE = 0.02
"""Least fraction of such a push that the heavier ball takes. At zero, a light ball under a heavy
one would be pushed to and fro between it and the floor; at a half, heavy balls would climb."""

PUSH_LIMIT = 0.25
"""Largest distance, in its radii, that other balls may push a ball in a substep. A wall pushes back
by the correction factor times the depth. So a ball cannot be pushed through a wall: with the least
factor, 0.4, it stays at most about 0.6 radii deep (0.25 / 0.4)."""

PROJECTION_PASSES = 64
"""Most passes over the overlapping pairs at the end of a step; usually none overlaps too much."""


@lean_kernel
def limit_pushes(pos: Floats, n: int, push_left: Floats) -> None:
    """Set `push_left` (n,), the distance in m by which each ball may still be pushed."""
    for i in range(n):
        push_left[i] = PUSH_LIMIT * pos[i, body.RADIUS]


@lean_kernel
def push_apart(
    pos: Floats, push_left: Floats, a: int, b: int, nx: float, ny: float, push: float, share: float
) -> None:
    """Move a and b apart by `push` in m; share: a's fraction, 1 if b is a fixed shape."""
    da = push * share
    if b < len(push_left):
        db = push - da
        da = min(da, push_left[a])
        db = min(db, push_left[b])
        push_left[a] -= da
        push_left[b] -= db
        pos[b, body.X] -= db * nx
        pos[b, body.Y] -= db * ny
    pos[a, body.X] += da * nx
    pos[a, body.Y] += da * ny


@lean_kernel
def _project_deep(
    bodies: Bodies, pairs: NeighbourList, statics: StaticShapes, push_left: Floats
) -> bool:
    """Push apart the pairs that overlap by more than DEEP; return whether there were any."""
    pos = bodies.pos
    vel = bodies.vel
    marks = bodies.marks
    items = statics.items
    starts = pairs.starts
    other = pairs.other
    fixed = len(pos) - 1
    is_any = False
    for a in range(len(starts) - 1):
        for k in range(starts[a], starts[a + 1]):
            b = other[k]
            dx, dy, contact_distance, small = separation(pos, items, a, b)
            inner = contact_distance - DEEP * small
            dd = dx * dx + dy * dy
            if dd >= inner * inner or dd == 0.0:
                continue
            if marks[a, body.FLAGS] & body.GONE or (b >= 0 and marks[b, body.FLAGS] & body.GONE):
                continue
            distance = sqrt(dd)
            partner = fixed
            share = 1.0
            if b >= 0 and marks[b, body.FLAGS] & body.ASLEEP == 0:
                partner = b
                wa = vel[a, body.INVERSE_MASS]
                share = wa / (wa + vel[b, body.INVERSE_MASS])
                share = min(max(share, LEAST_SHARE), 1.0 - LEAST_SHARE)
            push = inner - distance + DEEP * small * 0.25
            push_apart(pos, push_left, a, partner, dx / distance, dy / distance, push, share)
            is_any = True
    return is_any


@lean_kernel
def project_positions(
    bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes, push_left: Floats
) -> None:
    """Push apart all pairs that overlap by more than DEEP, in at most PROJECTION_PASSES passes.

    push_left (n,): work space.
    """
    limit_pushes(bodies.pos, n, push_left)
    for _ in range(PROJECTION_PASSES):
        if not _project_deep(bodies, pairs, statics, push_left):
            break


@kernel
def deepest_overlap(
    bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes
) -> tuple[float, float, int]:
    """Deepest overlap of the listed pairs in m and in radii of the smaller ball, and the number of
    pairs in contact."""
    metres = 0.0
    radii = 0.0
    touching = 0
    for a in range(n):
        for k in range(pairs.starts[a], pairs.starts[a + 1]):
            b = int(pairs.other[k])
            dx, dy, contact_distance, small = separation(bodies.pos, statics.items, a, b)
            touch_distance = contact_distance + SPECULATIVE_GAP * small
            dd = dx * dx + dy * dy
            if dd >= touch_distance * touch_distance:
                continue
            touching += 1
            depth = contact_distance - sqrt(dd)
            metres = max(metres, depth)
            radii = max(radii, depth / small)
    return metres, radii, touching
