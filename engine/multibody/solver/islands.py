"""Sleep of balls that touch each other: islands at rest fall asleep together and wake together."""

from math import sqrt

import numpy as np

from engine.jit.decorator import kernel, lean_kernel
from engine.multibody.solver.contact_solver import TOUCH, separation
from engine.multibody.solver.impact import wake
from engine.multibody.solver.layout import (
    ASLEEP,
    FLAGS,
    GONE,
    RADIUS,
    RING,
    ROLL,
    STILL,
    VX,
    VY,
    Bodies,
    Ints,
    Pairs,
    Settings,
    Statics,
)

STILLNESS = 0.01
"""Speed below which a ball counts as still, in sqrt(g R), what it gains by falling half a radius.
Larger ones are seen as a stop; below the jitter of a pile's contact impulses it never sleeps."""


@lean_kernel
def _root(parents: Ints, i: int) -> int:
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@lean_kernel
def count_still(bodies: Bodies, n: int, settings: Settings) -> int:
    """Count the frames in which each awake ball was still; how many may sleep."""
    ready = 0
    for i in range(n):
        if bodies.marks[i, FLAGS] & (ASLEEP | GONE):
            continue
        vx = bodies.vel[i, VX]
        vy = bodies.vel[i, VY]
        roll = bodies.vel[i, ROLL]
        limit = STILLNESS * STILLNESS * settings.gravity * bodies.pos[i, RADIUS]
        if vx * vx + vy * vy + roll * roll <= limit:
            if bodies.marks[i, STILL] < settings.sleep_frames:
                bodies.marks[i, STILL] += 1
            if bodies.marks[i, STILL] >= settings.sleep_frames:
                ready += 1
        else:
            bodies.marks[i, STILL] = 0
    return ready


@kernel
def send_to_sleep(
    bodies: Bodies, n: int, pairs: Pairs, statics: Statics, settings: Settings
) -> bool:
    """Let every island sleep whose balls all were still long enough; whether there was one."""
    parents = np.empty(n, np.int32)
    for i in range(n):
        parents[i] = i
    for a in range(n):
        for k in range(pairs.starts[a], pairs.starts[a + 1]):
            b = int(pairs.other[k])
            if b < 0 or bodies.marks[b, FLAGS] & ASLEEP:
                continue
            dx, dy, reach, small = separation(bodies.pos, statics.items, a, b)
            near = reach + TOUCH * small
            if dx * dx + dy * dy < near * near:
                ra = _root(parents, a)
                rb = _root(parents, b)
                if ra < rb:
                    parents[rb] = ra
                else:
                    parents[ra] = rb
    is_restless = np.zeros(n, np.bool_)
    for i in range(n):
        if bodies.marks[i, STILL] < settings.sleep_frames:
            is_restless[_root(parents, i)] = True
    slept = False
    last = np.full(n, -1, np.int32)
    for i in range(n):
        if bodies.marks[i, FLAGS] & (ASLEEP | GONE):
            continue
        root = _root(parents, i)
        if is_restless[root]:
            continue
        slept = True
        bodies.marks[i, FLAGS] |= ASLEEP
        bodies.vel[i, VX] = 0.0
        bodies.vel[i, VY] = 0.0
        bodies.vel[i, ROLL] = 0.0
        # The ring of an island: from its last member on to its first, the root.
        bodies.marks[i, RING] = root
        if last[root] >= 0:
            bodies.marks[last[root], RING] = i
        last[root] = i
    return slept


@lean_kernel
def wake_touched(bodies: Bodies, n: int, pairs: Pairs, statics: Statics) -> bool:
    """Wake all sleepers that an awake ball touches; whether there were any."""
    woke = False
    for a in range(n):
        for k in range(pairs.starts[a], pairs.starts[a + 1]):
            b = int(pairs.other[k])
            if b < 0 or bodies.marks[b, FLAGS] & ASLEEP == 0:
                continue
            dx, dy, reach, _ = separation(bodies.pos, statics.items, a, b)
            if sqrt(dx * dx + dy * dy) <= reach:
                wake(bodies.marks, b)
                woke = True
    return woke
