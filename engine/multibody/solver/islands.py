"""Islands of balls that touch each other: they fall asleep together at rest, and wake together.

They are found by union-find with path halving (Tarjan and van Leeuwen, JACM 1984), as in Box2D 3. A
sleeping island is a circular linked list of its balls (NEXT_IN_ISLAND).
"""

from math import sqrt

import numpy as np

from plinko.engine.jit.decorator import inner_kernel, lean_kernel
from plinko.engine.multibody.solver.layout import body
from plinko.engine.multibody.solver.layout.array_types import Ints
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.pair import NeighbourList
from plinko.engine.multibody.solver.layout.shape import StaticShapes
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.multibody.solver.narrow_phase import SPECULATIVE_GAP, separation

STILLNESS = 0.01
"""Speed below which a ball counts as still, in units of sqrt(g R), the speed after a fall of half a
radius. With a larger value, balls would visibly stop when they fall asleep. With a value below the
jitter of contact impulses, a pile would never sleep."""


@lean_kernel
def wake_island(marks: Ints, i: int) -> None:
    """Wake ball i and all balls that fell asleep with it."""
    j = i
    while marks[j, body.FLAGS] & body.ASLEEP:
        marks[j, body.FLAGS] &= ~body.ASLEEP
        marks[j, body.STILL_STEPS] = 0
        following = marks[j, body.NEXT_IN_ISLAND]
        marks[j, body.NEXT_IN_ISLAND] = j
        j = following


@lean_kernel
def _find_root(parents: Ints, i: int) -> int:
    """Return the root of i's set in the union-find forest, and halve the path to it."""
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@lean_kernel
def _union(parents: Ints, a: int, b: int) -> None:
    """Join the sets of a and b; the smallest row becomes the root."""
    ra = _find_root(parents, a)
    rb = _find_root(parents, b)
    if ra < rb:
        parents[rb] = ra
    else:
        parents[ra] = rb


@lean_kernel
def count_still_steps(bodies: Bodies, n: int, settings: SolverSettings) -> int:
    """Update each awake ball's count of still steps; return how many balls may sleep."""
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
    """A union-find forest (n,) of the balls, in which balls that touch have the same root."""
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
    """Put every island to sleep whose balls were all still long enough; return if there was one."""
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
        # Append to the island's circular list: the last ball points to the first, the root.
        marks[i, body.NEXT_IN_ISLAND] = root
        if last[root] >= 0:
            marks[last[root], body.NEXT_IN_ISLAND] = i
        last[root] = i
    return slept


@lean_kernel
def wake_touched(bodies: Bodies, n: int, pairs: NeighbourList, statics: StaticShapes) -> bool:
    """Wake all islands that an awake ball touches; return whether there were any."""
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
