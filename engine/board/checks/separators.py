"""Finds the separators: lines that a ball's centre can never cross, which decide where it gets.

The centre stays out of convex sets: discs, strips along walls, everything above the start (a ball
that starts at rest never rises above it, because restitution is at most 1 and drag takes energy)
and everything below the bins (where the drop has ended). The separators are the walls, and a line
inside each two sets that overlap: from peg to peg, from peg to wall, from a peg up past the start's
height or down past the bins. By the nerve theorem, every loop within the union of the sets can be
shrunk onto such lines. So a path through free places connects two free places exactly if some path
that avoids the lines does. This needs no tolerance: a gap that is narrower than the ball by a
rounding error is closed, and a gap that is wider by one is open.

The lines are also far apart. Obstacles with a gap for the ball are at least its diameter apart, and
an obstacle is at least sqrt(3) R from any line of other obstacles, if the ball fits between them.
"""

import numpy as np

from plinko.engine.board.checks.obstacles import Floats, Ints, Obstacles, near_walls


def separators(
    obs: Obstacles, pairs: tuple[Ints, Ints, Floats], top: float, bottom: float
) -> Floats:
    """Return the separators as segments, shape (k, 4): x1, y1, x2, y2 in m.

    pairs: from `close_discs`. top, bottom: y of the start and of the bins in m.
    """
    i, j, apart = pairs
    i, j = i[apart > 0.0], j[apart > 0.0]
    beyond = obs.radius + float(np.max(obs.reach, initial=0.0))
    above = np.flatnonzero(obs.y - obs.reach < top)
    below = np.flatnonzero(obs.y + obs.reach > bottom)
    return np.concatenate(
        (
            np.column_stack((obs.x1, obs.y1, obs.x2, obs.y2)),
            np.column_stack((obs.x[i], obs.y[i], obs.x[j], obs.y[j])),
            _plumb_lines(obs.x[above], obs.y[above], top - beyond),
            _plumb_lines(obs.x[below], obs.y[below], bottom + beyond),
            *_to_walls(obs),
        ),
    )


def _plumb_lines(x: Floats, y: Floats, end: float) -> Floats:
    return np.column_stack((x, y, x, np.full(len(x), end)))


def _to_walls(obs: Obstacles) -> list[Floats]:
    """Lines from discs to walls that are too close for the ball to pass, ending behind the wall.

    If a line ended on the wall, rounding would decide whether the two meet. The ball's centre
    cannot be within R behind the wall either, so a longer line closes no gap.
    """
    lines = []
    margin = 1e-9 * obs.radius  # without it, rounding could count a disc on a wall's end here
    for k, near, along, across in near_walls(obs):
        beside = (along > margin) & (along < obs.length[k] - margin)
        if not beside.any():
            continue
        disc, s = near[beside], along[beside]
        through = -0.1 * obs.radius * np.copysign(1.0, across[beside])
        x = obs.x1[k] + s * obs.tx[k] - through * obs.ty[k]
        y = obs.y1[k] + s * obs.ty[k] + through * obs.tx[k]
        lines.append(np.column_stack((obs.x[disc], obs.y[disc], x, y)))
    return lines
