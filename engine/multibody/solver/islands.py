"""Islands: balls that touch each other fall asleep together at rest, and wake together.

The islands are found by union-find with path halving (Tarjan and van Leeuwen, JACM 1984), as in
Box2D 3. An island that sleeps is a circular linked list of its balls (NEXT_IN_ISLAND).
"""

from math import sqrt

import numpy as np

from engine.jit.decorator import inner_kernel, lean_kernel
from engine.multibody.solver.layout import body
from engine.multibody.solver.layout.array_types import Ints
from engine.multibody.solver.layout.body import Bodies
from engine.multibody.solver.layout.pair import NeighbourList
from engine.multibody.solver.layout.shape import StaticShapes
from engine.multibody.solver.layout.solver_settings import SolverSettings
from engine.multibody.solver.narrow_phase import SPECULATIVE_GAP, separation

STILLNESS = 0.01
"""Speed below which a ball counts as still, in sqrt(g R), what it gains by falling half a radius.
Larger ones are seen as a stop; below the jitter of a pile's contact impulses it never sleeps."""


@lean_kernel
def wake_island(marks: Ints, i: int) -> None:
    """Wake ball i and all that fell asleep with it."""
    j = i
    while marks[j, body.FLAGS] & body.ASLEEP:
        marks[j, body.FLAGS] &= ~body.ASLEEP
        marks[j, body.STILL_STEPS] = 0
        following = marks[j, body.NEXT_IN_ISLAND]
        marks[j, body.NEXT_IN_ISLAND] = j
        j = following


@lean_kernel
def _find_root(parents: Ints, i: int) -> int:
    """The root of i's set in the union-find forest; paths to it are halved."""
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@lean_kernel
def _union(parents: Ints, a: int, b: int) -> None:
    """Join the sets of a and b; the least member is the root."""
    ra = _find_root(parents, a)
    rb = _find_root(parents, b)
    if ra < rb:
        parents[rb] = ra
    else:
        parents[ra] = rb


@lean_kernel
def count_still_steps(bodies: Bodies, n: int, settings: SolverSettings) -> int:
    """Count the steps in which each awake ball was still; how many may sleep."""
    marks = bodies.marks
    ready = 0
    for i in range(n):
        if marks[i, body.FLAGS] & (body.ASLEEP | body.GONE):
            continue
        vx = bodies.vel[i, body.VX]
        vy = bodies.vel[i, body.VY]
        rim = bodies.vel[i, body.RIM_SPEED]
        limit = STILLNESS * STILLNESS * settings.gravity * bodies.pos[i, body.RADIUS]
        if vx * vx + vy * vy + rim * rim <= limit:
            if marks[i, body.STILL_STEPS] < settings.sleep_steps:
                marks[i, body.STILL_STEPS] += 1
            if marks[i, body.STILL_STEPS] >= settings.sleep_steps:
                ready += 1
        else:
            marks[i, body.STILL_STEPS] = 0
    return ready


@inner_kernel
def find_islands(bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes) -> Ints:
    """A union-find forest (n,) of the balls: those that touch each other have one root."""
    parents = np.empty(n, np.int32)
    for i in range(n):
        parents[i] = i
    for a in range(n):
        for k in range(pairs.starts[a], pairs.starts[a + 1]):
            b = int(pairs.other[k])
            if b < 0 or bodies.marks[b, body.FLAGS] & body.ASLEEP:
                continue
            dx, dy, contact_distance, small = separation(bodies.pos, statics.items, a, b)
            touch_distance = contact_distance + SPECULATIVE_GAP * small
            if dx * dx + dy * dy < touch_distance * touch_distance:
                _union(parents, a, b)
    return parents


@inner_kernel
def put_islands_to_sleep(
    bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes, settings: SolverSettings
) -> bool:
    """Let every island sleep whose balls all were still long enough; whether there was one."""
    marks = bodies.marks
    parents = find_islands(bodies, n, pairs, statics)
    is_restless = np.zeros(n, np.bool_)
    for i in range(n):
        if marks[i, body.STILL_STEPS] < settings.sleep_steps:
            is_restless[_find_root(parents, i)] = True
    slept = False
    last = np.full(n, -1, np.int32)
    for i in range(n):
        if marks[i, body.FLAGS] & (body.ASLEEP | body.GONE):
            continue
        root = _find_root(parents, i)
        if is_restless[root]:
            continue
        slept = True
        marks[i, body.FLAGS] |= body.ASLEEP
        bodies.vel[i, body.VX] = 0.0
        bodies.vel[i, body.VY] = 0.0
        bodies.vel[i, body.RIM_SPEED] = 0.0
        # The island's list: from its last member on to its first, the root.
        marks[i, body.NEXT_IN_ISLAND] = root
        if last[root] >= 0:
            marks[last[root], body.NEXT_IN_ISLAND] = i
        last[root] = i
    return slept


@lean_kernel
def wake_touched(bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes) -> bool:
    """Wake the islands that an awake ball touches; whether there were any."""
    woke = False
    for a in range(n):
        for k in range(pairs.starts[a], pairs.starts[a + 1]):
            b = int(pairs.other[k])
            if b < 0 or bodies.marks[b, body.FLAGS] & body.ASLEEP == 0:
                continue
            dx, dy, contact_distance, _ = separation(bodies.pos, statics.items, a, b)
            if sqrt(dx * dx + dy * dy) <= contact_distance:
                wake_island(bodies.marks, b)
                woke = True
    return woke
