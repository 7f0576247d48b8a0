"""The ends of flights and the impacts there, side by side: `rebound` and `bounce` of all balls."""

from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.free_flight import DYING_BOUNCE, TRUE_WITHIN
from plinko.engine.exact.lanes import flight, lane
from plinko.engine.exact.lanes.flight import bases
from plinko.engine.exact.lanes.lane import Space
from plinko.engine.jit.decorator import lean_kernel
from plinko.engine.physics import body, surface
from plinko.engine.physics.array_types import Floats

CAREFUL = 0.5 * TRUE_WITHIN
"""A ball that comes this near to failing the check of `rebound` goes to the solver for one ball."""

# Where the columns of `e` begin, shape (IMPACT_COLUMNS * LANES,): the flight's duration and its
# `flight.bases`; the state at its end, in the order of `body`; the surface and its material; …
BASIS = 0 * lane.LANES
END = 4 * lane.LANES
T = END + body.T * lane.LANES
X = END + body.X * lane.LANES
Y = END + body.Y * lane.LANES
VX = END + body.VX * lane.LANES
VY = END + body.VY * lane.LANES
OMEGA = END + body.OMEGA * lane.LANES
CENTRE_X = 11 * lane.LANES  # or the first end of a line
CENTRE_Y = 12 * lane.LANES
DISTANCE = 13 * lane.LANES
INVERSE = 14 * lane.LANES
LINE_NX = 15 * lane.LANES  # a line's normal towards the ball
LINE_NY = 16 * lane.LANES
RESTITUTION = 17 * lane.LANES
FRICTION = 18 * lane.LANES
AFTER = 19 * lane.LANES  # … the state after the impact; and whether the ball cannot fly on:
STOOD = 26 * lane.LANES  # 1: it has not moved, within rounding
DIES = 27 * lane.LANES  # 1: the bounce has died, or may be false


@lean_kernel
def arrive(board: BoardArrays, space: Space, count: int, drags: bool) -> None:
    """Move the balls in the lanes ended[:count] to the ends of their flights."""
    w, m, e = space.w, space.m, space.e
    items = board.items
    k = board.drag
    for c in range(count):
        i = int(space.ended[c])
        item = max(m[lane.ITEM + i], 0)
        e[BASIS + flight.TIME + c] = w[lane.START + i]
        for column in range(body.SIZE):
            e[END + column * lane.LANES + c] = w[column * lane.LANES + i]
        e[CENTRE_X + c] = items[item, surface.X]
        e[CENTRE_Y + c] = items[item, surface.Y]
        e[DISTANCE + c] = items[item, surface.DISTANCE]
        e[INVERSE + c] = items[item, surface.INVERSE]
        e[LINE_NX + c] = w[lane.HIT_SIDE + i] * items[item, surface.NX]
        e[LINE_NY + c] = w[lane.HIT_SIDE + i] * items[item, surface.NY]
        is_peg = item < board.peg_count
        e[RESTITUTION + c] = board.peg_restitution if is_peg else board.wall_restitution
        e[FRICTION + c] = board.peg_friction if is_peg else board.wall_friction
    if drags:
        bases(e, BASIS, count, k)
    for c in range(count):
        s = e[BASIS + flight.TIME + c]
        phi = e[BASIS + flight.PHI + c] if drags else s
        psi = e[BASIS + flight.PSI + c] if drags else 0.5 * s * s
        t = e[T + c]
        x, y = e[X + c], e[Y + c]
        vx, vy = e[VX + c], e[VY + c]
        ax = -k * vx
        ay = board.gravity - k * vy
        end = t + s
        end_x = x + vx * s + ax * psi
        end_y = y + vy * s + ay * psi
        moved = abs(end_x - x) + abs(end_y - y)
        stood = (end == t) | (moved <= surface.rounding(end_x, end_y))
        e[T + c] = end
        e[X + c] = end_x
        e[Y + c] = end_y
        e[VX + c] = vx + ax * phi
        e[VY + c] = vy + ay * phi
        e[STOOD + c] = 1.0 if stood else 0.0


@lean_kernel
def rebound_all(e: Floats, count: int, radius: float, rubs: bool) -> None:
    """`rebound` of the first `count` balls; rubs: whether any ball may have friction or spin."""
    for c in range(count):
        e[AFTER + body.T * lane.LANES + c] = e[T + c]
        x, y = e[X + c], e[Y + c]
        vx, vy = e[VX + c], e[VY + c]
        omega, distance = e[OMEGA + c], e[DISTANCE + c]
        dx = x - e[CENTRE_X + c]
        dy = y - e[CENTRE_Y + c]
        is_circle = distance > 0.0
        nx, ny = dx * e[INVERSE + c], dy * e[INVERSE + c]
        square = nx * nx + ny * ny
        unit = 1.5 - 0.5 * square
        nx = nx * unit if is_circle else e[LINE_NX + c]
        ny = ny * unit if is_circle else e[LINE_NY + c]
        gap = radius - (dx * nx + dy * ny)
        e[AFTER + body.X * lane.LANES + c] = (
            e[CENTRE_X + c] + distance * nx if is_circle else x + gap * nx
        )
        e[AFTER + body.Y * lane.LANES + c] = (
            e[CENTRE_Y + c] + distance * ny if is_circle else y + gap * ny
        )
        vn = vx * nx + vy * ny
        jn = -(1.0 + e[RESTITUTION + c]) * vn
        ux = vx + jn * nx
        uy = vy + jn * ny
        spin = omega
        if rubs:
            slip = uy * nx - ux * ny - omega * radius
            jt = slip * (-1.0 / 3.0)
            limit = e[FRICTION + c] * jn
            jt = limit if jt > limit else (-limit if jt < -limit else jt)
            has_friction = e[FRICTION + c] > 0.0
            ux = ux - jt * ny if has_friction else ux
            uy = uy + jt * nx if has_friction else uy
            spin = omega - 2.0 * jt / radius if has_friction else omega
        strikes = vn < 0.0
        ux = ux if strikes else vx
        uy = uy if strikes else vy
        e[AFTER + body.VX * lane.LANES + c] = ux
        e[AFTER + body.VY * lane.LANES + c] = uy
        e[AFTER + body.OMEGA * lane.LANES + c] = spin if strikes else omega
        # The check of `rebound`; where it may fail, the solver for one ball decides.
        off = 0.5 * distance * (square - 1.0) if is_circle else gap
        turn = spin if strikes else omega
        before = vx * vx + vy * vy + 0.5 * radius * radius * omega * omega
        after = ux * ux + uy * uy + 0.5 * radius * radius * turn * turn
        may_be_false = (abs(off) > CAREFUL * radius) | (after > before * (1.0 + CAREFUL))
        dies = ux * nx + uy * ny <= DYING_BOUNCE
        e[DIES + c] = 1.0 if dies | may_be_false else 0.0
