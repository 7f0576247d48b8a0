"""Lines that a ball's centre can never cross, which decide exactly what it can reach.

The centre is kept out of convex sets: discs, strips along walls, everything above the start (a
ball that starts at rest never rises above it: restitution is at most 1 and drag takes) and
everything below the bins (where the drop has ended). Draw a line between every two sets that
overlap, inside the two: peg to peg, peg to wall, peg up to the start's height or down to the bins;
and draw the walls. By the nerve theorem every loop within the union of the sets can be shrunk
onto such lines, so two free places are connected by free places exactly if they are connected by
places off the lines. There is no tolerance in this: a gap a rounding error narrower than the ball
is closed, one wider is open.

The lines are also far apart. Obstacles that a ball passes between are at least its diameter apart,
and an obstacle is at least sqrt(3) R from a line that it is not part of, if the ball fits between.
"""

import numpy as np

from engine.board.checks.obstacles import Floats, Ints, Obstacles, near_walls


def separators(
    obs: Obstacles, pairs: tuple[Ints, Ints, Floats], top: float, bottom: float
) -> Floats:
    """Return the separators as segments, shape (k, 4): x1, y1, x2, y2 in m.

    pairs: from `close_discs`. top, bottom: heights of the start and of the bins in m.
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
    """Lines from discs to the walls that they are too close to, a little through the wall.

    Ending on it would leave the joint to rounding. The other side is out of bounds as well, up to
    R from the wall.
    """
    lines = []
    margin = 1e-9 * obs.radius  # a disc on an end is beside nothing, whatever rounding says
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
