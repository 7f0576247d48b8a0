"""Lays out a board's surfaces: which surface owns each point of the boundary.

The ball's centre moves among solids that are grown by its radius R: a peg is a disc, a wall the
stadium of all points within R of it. The surface of a board is the boundary of the union of these
solids, and each of its points has one owner:

    a peg owns       its circle.
    a wall owns      its two lines, between its ends. Walls that overlap, or continue each other,
                     along one straight line are one wall, whose pieces have no ends between them.
                     A point of it has the index of the lowest-numbered piece there.
    an end owns      the half circle around it. Walls that end in one point share it. An end that
                     lies on another wall or on a peg owns nothing: its circle is inside them.

Everything is decided within the rounding of a position (`surface.rounding`). Flight and contact
find the boundary by themselves wherever two surfaces cross, because the ball meets the outer one
first. What remains are surfaces that touch without crossing: where a line continues as a circle.
There the ball passes from one to the other; see `surface.is_flush`.

Each item is a row of `surface`. Items are the pegs, then for each wall its line and its two ends.
Items that own nothing name their OWNER, and no cell of the grid lists them.
"""

from math import sqrt

from plinko.engine.jit.decorator import inner_kernel
from plinko.engine.physics import surface
from plinko.engine.physics.array_types import Floats
from plinko.engine.physics.surface import Surfaces, rounding

NONE = -1.0


@inner_kernel
def lay_out(pegs: Floats, walls: Floats, radius: float, items: Surfaces) -> None:
    """Write the surfaces into `items`, shape (n + 3 m, surface.COLUMNS).

    pegs: (n, 3), x, y and radius; walls: (m, 4), x1, y1, x2, y2; radius: the ball's. All in m.
    """
    for i in range(len(pegs)):
        _set_circle(items, i, pegs[i, 0], pegs[i, 1], radius + pegs[i, 2])
    for line in range(len(pegs), len(items), 3):
        wall = walls[(line - len(pegs)) // 3]
        _set_line(items, line, wall[0], wall[1], wall[2], wall[3])
        items[line, surface.OWNER] = line
        items[line, surface.FIRST_END] = line + 1
        items[line, surface.LAST_END] = line + 2
        items[line, surface.NEXT] = NONE
        _set_circle(items, line + 1, wall[0], wall[1], radius)
        _set_circle(items, line + 2, wall[2], wall[3], radius)
    for line in range(len(pegs), len(items), 3):
        _join(items, line)
    _list_pieces(items, len(pegs), walls)
    for line in range(len(pegs), len(items), 3):
        if items[line, surface.OWNER] == line:
            _find_ends(items, len(pegs), line)
    for line in range(len(pegs), len(items), 3):
        if items[line, surface.OWNER] == line:
            for column in (surface.FIRST_END, surface.LAST_END):
                _pass_on_end(items, len(pegs), radius, line, column)


@inner_kernel
def _set_circle(items: Surfaces, item: int, x: float, y: float, distance: float) -> None:
    items[item, surface.X] = x
    items[item, surface.Y] = y
    items[item, surface.DISTANCE] = distance
    items[item, surface.DISTANCE2] = distance * distance
    items[item, surface.INVERSE] = 1.0 / distance
    items[item, surface.OWNER] = item


@inner_kernel
def _set_line(items: Surfaces, line: int, x1: float, y1: float, x2: float, y2: float) -> None:
    dx = x2 - x1
    dy = y2 - y1
    length = sqrt(dx * dx + dy * dy)
    items[line, surface.X] = x1
    items[line, surface.Y] = y1
    items[line, surface.DISTANCE] = 0.0
    items[line, surface.LENGTH] = length
    items[line, surface.TX] = dx / length
    items[line, surface.TY] = dy / length
    items[line, surface.NX] = -dy / length
    items[line, surface.NY] = dx / length
    items[line, surface.END_X] = x2
    items[line, surface.END_Y] = y2


@inner_kernel
def _place_on(items: Surfaces, line: int, x: float, y: float) -> tuple[float, float, float]:
    """Where a point is along a line and across it, and the rounding of both, in m."""
    dx = x - items[line, surface.X]
    dy = y - items[line, surface.Y]
    along = dx * items[line, surface.TX] + dy * items[line, surface.TY]
    across = dx * items[line, surface.NX] + dy * items[line, surface.NY]
    return along, across, rounding(x, y) + rounding(items[line, surface.X], items[line, surface.Y])


@inner_kernel
def _join(items: Surfaces, line: int) -> None:
    """Make `line` one wall with all later walls that overlap or continue it."""
    grows = items[line, surface.OWNER] == line
    while grows:
        grows = False
        for other in range(line + 3, len(items), 3):
            if items[other, surface.OWNER] == other and _are_one(items, line, other):
                _extend(items, line, other)
                items[other, surface.OWNER] = line
                grows = True


@inner_kernel
def _are_one(items: Surfaces, a: int, b: int) -> bool:
    """Whether two walls lie on one straight line, without a gap between them."""
    is_shorter = items[a, surface.LENGTH] < items[b, surface.LENGTH]
    base = b if is_shorter else a
    other = a if is_shorter else b
    s1, off1, near1 = _place_on(items, base, items[other, surface.X], items[other, surface.Y])
    s2, off2, near2 = _place_on(
        items, base, items[other, surface.END_X], items[other, surface.END_Y]
    )
    if abs(off1) > near1 or abs(off2) > near2:
        return False
    near = max(near1, near2)
    return bool(max(s1, s2) >= -near and min(s1, s2) <= items[base, surface.LENGTH] + near)


@inner_kernel
def _extend(items: Surfaces, line: int, other: int) -> None:
    """Let `line` reach to the outermost ends of both; the direction stays that of `line`."""
    x1, y1 = items[line, surface.X], items[line, surface.Y]
    x2, y2 = items[line, surface.END_X], items[line, surface.END_Y]
    first = items[line, surface.FIRST_END]
    last = items[line, surface.LAST_END]
    low = 0.0
    high = items[line, surface.LENGTH]
    for column in (surface.FIRST_END, surface.LAST_END):
        end = int(items[other, column])
        x, y = items[end, surface.X], items[end, surface.Y]
        along, _, _ = _place_on(items, line, x, y)
        if along < low:
            low = along
            x1, y1, first = x, y, float(end)
        if along > high:
            high = along
            x2, y2, last = x, y, float(end)
    _set_line(items, line, x1, y1, x2, y2)
    items[line, surface.FIRST_END] = first
    items[line, surface.LAST_END] = last


@inner_kernel
def _list_pieces(items: Surfaces, peg_count: int, walls: Floats) -> None:
    """Link the pieces of each wall by ascending number, with their places along it.

    The ends of all pieces become the wall's; `_find_ends` gives it back the outermost two.
    """
    for line in range(len(items) - 3, peg_count - 1, -3):
        owner = int(items[line, surface.OWNER])
        x1, y1, x2, y2 = walls[(line - peg_count) // 3]
        s1, _, _ = _place_on(items, owner, x1, y1)
        s2, _, _ = _place_on(items, owner, x2, y2)
        items[line, surface.FROM] = min(s1, s2)
        items[line, surface.TO] = max(s1, s2)
        items[line + 1, surface.OWNER] = owner
        items[line + 2, surface.OWNER] = owner
        if owner != line:
            items[line, surface.NEXT] = items[owner, surface.NEXT]
            items[owner, surface.NEXT] = line


@inner_kernel
def _find_ends(items: Surfaces, peg_count: int, line: int) -> None:
    """Make each end of a wall an owner, or let it share an earlier wall's end in the same place."""
    for column in (surface.FIRST_END, surface.LAST_END):
        end = int(items[line, column])
        x, y = items[end, surface.X], items[end, surface.Y]
        items[end, surface.OWNER] = end
        for other in range(peg_count, len(items)):
            if (
                other != end
                and items[other, surface.DISTANCE] > 0.0
                and items[other, surface.OWNER] == other
                and abs(x - items[other, surface.X]) + abs(y - items[other, surface.Y])
                <= rounding(x, y)
            ):
                items[end, surface.OWNER] = other
                items[line, column] = other
                break


@inner_kernel
def _pass_on_end(items: Surfaces, peg_count: int, radius: float, line: int, column: int) -> None:
    """Take the circle from an end that lies on another wall or a peg.

    Where the wall is flush with the peg, its line continues as the peg's circle.
    """
    end = int(items[line, column])
    x, y = items[end, surface.X], items[end, surface.Y]
    for other in range(peg_count, len(items), 3):
        if items[other, surface.OWNER] == other:
            along, across, near = _place_on(items, other, x, y)
            if abs(across) <= near < along < items[other, surface.LENGTH] - near:
                items[end, surface.OWNER] = other
    for peg in range(peg_count):
        dx = x - items[peg, surface.X]
        dy = y - items[peg, surface.Y]
        reach = items[peg, surface.DISTANCE] - radius + rounding(x, y)
        if abs(dx) <= reach and abs(dy) <= reach and dx * dx + dy * dy <= reach * reach:
            items[end, surface.OWNER] = peg
            for way in range(2):
                if surface.is_flush(items, radius, line, 1.0 - 2.0 * way, peg):
                    items[line, column] = peg
