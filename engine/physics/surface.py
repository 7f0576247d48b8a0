"""Where a ball touches a surface: the normal, the tangential speed, the normal force."""

from math import sqrt

from engine.jit.decorator import inner_kernel
from engine.physics.layout import DISTANCE, NX, NY, Layout, X, Y


@inner_kernel
def touch(
    board: Layout, item: int, side: float, x: float, y: float
) -> tuple[float, float, float, float]:
    """Unit normal (nx, ny) of `item` towards a ball at (x, y), and the centre put on the surface.

    The centre is within rounding of the contact distance; putting it there exactly keeps the
    errors of many bounces on one surface from adding up.
    """
    items = board.items
    dx = x - items[item, X]
    dy = y - items[item, Y]
    distance = items[item, DISTANCE]
    if distance > 0.0:
        length = sqrt(dx * dx + dy * dy)
        nx = dx / length
        ny = dy / length
        return nx, ny, items[item, X] + distance * nx, items[item, Y] + distance * ny
    nx = side * items[item, NX]
    ny = side * items[item, NY]
    gap = board.radius - (dx * nx + dy * ny)
    return nx, ny, x + gap * nx, y + gap * ny


@inner_kernel
def curvature(board: Layout, item: int) -> float:
    """Curvature of the centre's path on `item`, 1/m: 1/D on a circle, 0 on a line."""
    distance = board.items[item, DISTANCE]
    return 1.0 / distance if distance > 0.0 else 0.0


@inner_kernel
def restitution_of(board: Layout, item: int) -> float:
    """Restitution between the ball and `item`."""
    return board.peg_restitution if item < board.peg_count else board.wall_restitution


@inner_kernel
def friction_of(board: Layout, item: int) -> float:
    """Coefficient of friction between the ball and `item`."""
    return board.peg_friction if item < board.peg_count else board.wall_friction


@inner_kernel
def is_wedged(board: Layout, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether gravity presses a ball that touches normals a and b against both.

    Gravity along a's tangent then pushes into b, and along b's tangent into a.
    """
    cross = ax * by - ay * bx
    # g.t of a normal n is gravity * n_x; t_a.n_b = cross, t_b.n_a = -cross.
    return bool(ax * cross < 0.0 < bx * cross and board.gravity > 0.0)
