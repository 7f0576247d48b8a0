"""Predicts the first impact of every ball on its path, by time-of-impact queries."""

from math import inf, sqrt

from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.multibody.solver.contact_solver import pair_restitution, restitution_threshold
from plinko.engine.multibody.solver.layout import body, shape, sweep
from plinko.engine.multibody.solver.layout.array_types import Floats, Ints
from plinko.engine.multibody.solver.layout.pair import NeighbourList
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.multibody.solver.layout.sweep import Sweeps
from plinko.engine.multibody.solver.narrow_phase import SLACK, time_of_impact, time_of_impact_wall


@lean_kernel
def _time_in_margin(anchor: Floats, i: int, x: float, y: float, vx: float, vy: float) -> float:
    """Seconds until ball i, which is at (x, y), leaves its margin; inf if it does not move."""
    vv = vx * vx + vy * vy
    dx = x - anchor[i, body.ANCHOR_X]
    dy = y - anchor[i, body.ANCHOR_Y]
    left = anchor[i, body.MARGIN] * anchor[i, body.MARGIN] - dx * dx - dy * dy
    dv = dx * vx + dy * vy
    s = 0.0
    if vv == 0.0:
        s = inf
    elif left > 0.0:
        s = (sqrt(dv * dv + vv * left) - dv) / vv
    return s


@lean_kernel
def _expiry(path: Floats, anchor: Floats, i: int, now: float, h: float) -> float:
    """Time in the substep, s, at which ball i leaves its margin, or inf."""
    vx = path[i, sweep.VX]
    vy = path[i, sweep.VY]
    dx = path[i, sweep.X0] + vx * h - anchor[i, body.ANCHOR_X]
    dy = path[i, sweep.Y0] + vy * h - anchor[i, body.ANCHOR_Y]
    t = inf
    if not dx * dx + dy * dy <= anchor[i, body.MARGIN] * anchor[i, body.MARGIN]:
        x = path[i, sweep.X0] + vx * now
        y = path[i, sweep.Y0] + vy * now
        t = now + _time_in_margin(anchor, i, x, y, vx, vy)
    return t


@lean_kernel
def _static_impact(
    path: Floats, items: Floats, i: int, item: int, x: float, y: float, remaining: float,
    settings: SolverSettings,
) -> float:  # fmt: skip
    """Seconds until ball i, which is at (x, y), hits a static item; inf if not in `remaining`."""
    vx = path[i, sweep.VX]
    vy = path[i, sweep.VY]
    radius = path[i, sweep.RADIUS]
    dx = x - items[item, shape.X1]
    dy = y - items[item, shape.Y1]
    length = items[item, shape.LENGTH]
    distance = radius + items[item, shape.RADIUS]
    restitution = pair_restitution(
        path[i, sweep.RESTITUTION], items[item, shape.RESTITUTION], settings.lesser
    )
    threshold = restitution_threshold(restitution, settings.gravity, settings.h, vx, vy, 0.0, 0.0)
    tx = items[item, shape.TX]
    ty = items[item, shape.TY]
    slack = SLACK * radius
    s = inf
    if length == 0.0:
        s = time_of_impact(dx, dy, vx, vy, distance, slack, threshold, remaining)
    elif abs(tx * dy - ty * dx) - abs(tx * vy - ty * vx) * remaining <= distance:
        s = time_of_impact_wall(
            dx, dy, vx, vy, tx, ty, length, distance, slack, threshold, remaining
        )
    return s


@lean_kernel
def _ball_impact(
    path: Floats, a: int, b: int, px: float, py: float, remaining: float, settings: SolverSettings
) -> float:
    """Seconds until ball a, at (px, py) relative to ball b, hits it; inf if not in `remaining`.

    Any touch of a sleeping ball counts, because it wakes the ball.
    """
    ra = path[a, sweep.RADIUS]
    rb = path[b, sweep.RADIUS]
    small = ra if ra < rb else rb
    threshold = 0.0
    slack = 0.0
    if path[b, sweep.STATUS] == sweep.AWAKE:
        restitution = pair_restitution(
            path[a, sweep.RESTITUTION], path[b, sweep.RESTITUTION], settings.lesser
        )
        threshold = restitution_threshold(
            restitution, settings.gravity, settings.h,
            path[a, sweep.VX], path[a, sweep.VY], path[b, sweep.VX], path[b, sweep.VY],
        )  # fmt: skip
        slack = SLACK * small
    vx = path[a, sweep.VX] - path[b, sweep.VX]
    vy = path[a, sweep.VY] - path[b, sweep.VY]
    return time_of_impact(px, py, vx, vy, ra + rb, slack, threshold, remaining)


@lean_kernel
def _may_hit(
    path: Floats, a: int, b: int, px: float, py: float, remaining: float, least_threshold: float
) -> bool:
    """Whether ball a, at (px, py) relative to ball b, can hit it within `remaining`.

    Most pairs cannot: they separate, are too far apart, or touch and approach too slowly for any
    pair to rebound. The test has no branches, because the processor would mispredict many.
    """
    vx = path[a, sweep.VX] - path[b, sweep.VX]
    vy = path[a, sweep.VY] - path[b, sweep.VY]
    ra = path[a, sweep.RADIUS]
    rb = path[b, sweep.RADIUS]
    small = ra if ra < rb else rb
    pv = px * vx + py * vy
    pp = px * px + py * py
    distance = ra + rb
    inner = distance - SLACK * small
    closest = pp + 2.0 * pv * remaining
    is_fast = pv * pv >= least_threshold * least_threshold * pp
    is_lively = is_fast | (path[b, sweep.STATUS] != sweep.AWAKE)
    is_near = (closest <= distance * distance) & (is_lively | (closest <= inner * inner))
    return bool((pv < 0.0) & is_near)


@lean_kernel
def _candidate_neighbours(
    path: Floats, pairs: NeighbourList, i: int, x: float, y: float, now: float, remaining: float,
    least_threshold: float, candidates: Ints,
) -> int:  # fmt: skip
    """List the neighbours that ball i, which is at (x, y), can hit, and all its static items.

    Returns their number.
    """
    neighbours = pairs.neighbours
    count = 0
    for k in range(pairs.neighbour_starts[i], pairs.neighbour_starts[i + 1]):
        b = neighbours[k]
        candidates[count] = b
        ball = b if b >= 0 else i
        px = x - (path[ball, sweep.X0] + path[ball, sweep.VX] * now)
        py = y - (path[ball, sweep.Y0] + path[ball, sweep.VY] * now)
        count += int((b < 0) | _may_hit(path, i, ball, px, py, remaining, least_threshold))
    return count


@lean_kernel
def predict(
    sweeps: Sweeps, anchor: Floats, items: Floats, pairs: NeighbourList, i: int, now: float,
    settings: SolverSettings, least_threshold: float, candidates: Ints,
) -> tuple[float, int]:  # fmt: skip
    """Predict ball i's next event: its time in the substep, s, and a ball, -1 - item, EXPIRY or
    NOTHING.

    One event per ball is enough. After a change of its velocity, a ball is predicted again with all
    its pairs; so is a ball whose partner has changed when its event comes. Of impacts at the same
    time, the first in the list counts.
    """
    path = sweeps.path
    h = settings.h
    best = h
    partner = sweep.NOTHING
    x = path[i, sweep.X0] + path[i, sweep.VX] * now
    y = path[i, sweep.Y0] + path[i, sweep.VY] * now
    t = _expiry(path, anchor, i, now, h)
    if t < best:
        best = t
        partner = sweep.EXPIRY
    count = _candidate_neighbours(
        path, pairs, i, x, y, now, best - now, least_threshold, candidates
    )
    for m in range(count):
        b = candidates[m]
        s = inf
        if b < 0:
            s = _static_impact(path, items, i, -1 - b, x, y, best - now, settings)
        elif path[b, sweep.STATUS] != sweep.GONE:
            px = x - (path[b, sweep.X0] + path[b, sweep.VX] * now)
            py = y - (path[b, sweep.Y0] + path[b, sweep.VY] * now)
            s = _ball_impact(path, i, b, px, py, best - now, settings)
        if now + s < best:
            best = now + s
            partner = b
    return best, partner


@lean_kernel
def _candidate_pairs(
    path: Floats, owner: Ints, other: Ints, now: float, remaining: float, least_threshold: float,
    candidates: Ints,
) -> int:  # fmt: skip
    """List the pairs of balls that can hit each other, and all with static items; return their
    number."""
    count = 0
    for k in range(len(other)):
        a = owner[k]
        b = other[k]
        candidates[count] = k
        if b >= 0:
            vx = path[a, sweep.VX] - path[b, sweep.VX]
            vy = path[a, sweep.VY] - path[b, sweep.VY]
            px = path[a, sweep.X0] - path[b, sweep.X0] + vx * now
            py = path[a, sweep.Y0] - path[b, sweep.Y0] + vy * now
            count += int(_may_hit(path, a, b, px, py, remaining, least_threshold))
        else:
            count += 1
    return count


@lean_kernel
def predict_all(
    sweeps: Sweeps, anchor: Floats, n: int, owner: Ints, other: Ints, items: Floats, now: float,
    settings: SolverSettings, least_threshold: float, may_expire: bool, candidates: Ints,
) -> bool:  # fmt: skip
    """Predict every ball's first event among the pairs that it owns; return whether there is any.

    This replaces `predict` for each ball, but tests every pair only once. may_expire: whether balls
    may leave their margins.
    """
    path = sweeps.path
    state = sweeps.state
    predicted = sweeps.predicted
    tree = sweeps.tree
    h = settings.h
    leaves = len(tree) // 2
    for i in range(n):
        tree[leaves + i] = inf
        if may_expire and path[i, sweep.STATUS] == sweep.AWAKE:
            t = _expiry(path, anchor, i, now, h)
            if t < h:
                tree[leaves + i] = t
                predicted[i, sweep.PARTNER] = sweep.EXPIRY
    count = _candidate_pairs(path, owner, other, now, h - now, least_threshold, candidates)
    for m in range(count):
        k = candidates[m]
        a = owner[k]
        b = other[k]
        if path[a, sweep.STATUS] != sweep.AWAKE:
            continue
        x = path[a, sweep.X0] + path[a, sweep.VX] * now
        y = path[a, sweep.Y0] + path[a, sweep.VY] * now
        s = inf
        if b < 0:
            s = _static_impact(path, items, a, -1 - b, x, y, h - now, settings)
        elif path[b, sweep.STATUS] != sweep.GONE:
            px = x - (path[b, sweep.X0] + path[b, sweep.VX] * now)
            py = y - (path[b, sweep.Y0] + path[b, sweep.VY] * now)
            s = _ball_impact(path, a, b, px, py, h - now, settings)
        if now + s < min(h, tree[leaves + a]):
            tree[leaves + a] = now + s
            predicted[a, sweep.PARTNER] = b
            if b >= 0:
                predicted[a, sweep.PARTNER_VERSION] = state[b, sweep.VERSION]
    for p in range(leaves - 1, 0, -1):
        left = tree[2 * p]
        right = tree[2 * p + 1]
        tree[p] = left if left <= right else right
    return bool(tree[1] < h)
