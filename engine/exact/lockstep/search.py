"""What the balls in the lanes hit first in their windows: many searches side by side."""

from typing import NamedTuple

import numpy as np

from engine.exact.board_arrays import BoardArrays
from engine.exact.lockstep import lanes
from engine.exact.lockstep.lanes import Floats, Indices, Ints, is_far
from engine.exact.next_impact import BOUNCED, FREE, NOWHERE, wall_hit
from engine.jit.decorator import lean_kernel
from engine.physics.circle_impact import (
    Motion,
    circle_search,
    third_derivative_bound,
    third_derivative_size,
)
from engine.physics.time_of_impact import MAX_STEPS, NEGLIGIBLE, NO_HIT, THIRD

ROOM = 2 * lanes.LANES
"""Searches in a list; one that is half full is searched before it goes on."""

WIDTH = 4
"""A list is filled up to a multiple of this, so that no search is left over from the vectors."""

# Where the searches' values begin in `r`, shape (SEARCH_COLUMNS * ROOM,): `circle_search`'s own, …
S = 0 * ROOM
F = 1 * ROOM
FD = 2 * ROOM
FDD = 3 * ROOM
TRUST = 4 * ROOM
SEARCHED = 5 * ROOM  # the window's length
FROM_X = 6 * ROOM
FROM_Y = 7 * ROOM
SPEED_X = 8 * ROOM
SPEED_Y = 9 * ROOM
SQUARE = 10 * ROOM
LOW3 = 11 * ROOM
SIZE3 = 12 * ROOM
STATUS = 13 * ROOM  # … and how far it has come:
SEARCH_COLUMNS = 14

SEARCHING = 0.0
HIT = 1.0
MISS = 2.0
RISES = 3.0  # moves away at first, which takes another formula
INSIDE = 4.0  # touches another surface as it starts


class Space(NamedTuple):
    """Work space of the lanes and of their searches."""

    w: Floats  # (FLOAT_COLUMNS * LANES,)
    m: Ints  # (INT_COLUMNS * LANES,)
    r: Floats  # (SEARCH_COLUMNS * ROOM,)
    whose: Indices  # (ROOM,): the lane of each search
    which: Indices  # (ROOM,): the surface that it looks for
    marked: Indices  # (LANES + 1,): lanes with a mark
    ended: Indices  # (LANES + 1,): lanes whose flights end in this window
    members: Indices  # the board's, and SLOTS more


def new_space(board: BoardArrays) -> Space:
    """Work space for drops on `board`."""
    return Space(
        w=np.zeros(lanes.FLOAT_COLUMNS * lanes.LANES),
        m=np.zeros(lanes.INT_COLUMNS * lanes.LANES, np.int64),
        r=np.zeros(SEARCH_COLUMNS * ROOM),
        whose=np.zeros(ROOM, np.uint32),
        which=np.zeros(ROOM, np.uint32),
        marked=np.zeros(lanes.LANES + 1, np.uint32),
        ended=np.zeros(lanes.LANES + 1, np.uint32),
        members=np.append(board.members, np.zeros(lanes.SLOTS, np.uint32)),
    )


@lean_kernel
def _list_marked(
    board: BoardArrays, space: Space, at: int, count: int, slots: int
) -> tuple[int, int]:
    """List the candidates of the lanes marked[at:count], until the list is half full.

    The first `slots` members of each cell have their marks; the others are looked at here. Returns
    the next lane's place in `marked`, and the number of candidates.
    """
    w, m, _, whose, which, marked, _, members = space
    starts = board.starts
    centres = board.centres
    gravity = board.gravity
    length = 0
    while at < count and length < ROOM // 2:
        i = int(marked[at])
        at += 1
        cell = np.uint32(m[lanes.CELL + i])
        first = starts[cell]
        more = starts[cell + 1] - first
        for slot in range(slots):
            which[np.uint32(length)] = members[first + slot]
            whose[np.uint32(length)] = i
            length += (m[lanes.MARK + i] >> slot) & 1
        for slot in range(slots, more):
            if length == ROOM - WIDTH:
                m[lanes.ODD + i] = 1
                break
            other = members[first + slot]
            d2 = centres[other, 2]
            may_hit = (d2 == 0.0) | (
                not is_far(w, i, centres[other, 0], centres[other, 1], d2, gravity)
            )
            which[np.uint32(length)] = other
            whose[np.uint32(length)] = i
            length += int(may_hit & (other != m[lanes.ORIGIN + i]))
    return at, length


@lean_kernel
def _open_searches(board: BoardArrays, space: Space, count: int) -> None:
    """Fill in the list's searches."""
    w, _, r, whose, which, _, _, _ = space
    centres = board.centres
    gravity = board.gravity
    for p in range(count):
        i = int(whose[p])
        other = which[p]
        r[FROM_X + p] = w[lanes.WX + i] - centres[other, 0]
        r[FROM_Y + p] = w[lanes.WY + i] - centres[other, 1]
        r[SQUARE + p] = centres[other, 2]
        r[SPEED_X + p] = w[lanes.WVX + i]
        r[SPEED_Y + p] = w[lanes.WVY + i]
        r[SEARCHED + p] = w[lanes.HORIZON + i]
    for p in range(count):
        qx = r[FROM_X + p]
        qy = r[FROM_Y + p]
        vx = r[SPEED_X + p]
        vy = r[SPEED_Y + p]
        horizon = r[SEARCHED + p]
        va = vy * gravity
        qa = qy * gravity
        aa = gravity * gravity
        f = qx * qx + qy * qy - r[SQUARE + p]
        fd = 2.0 * (qx * vx + qy * vy)
        r[S + p] = 0.0
        r[F + p] = f
        r[FD + p] = fd
        r[FDD + p] = 2.0 * (vx * vx + vy * vy + qa)
        r[TRUST + p] = horizon
        r[LOW3 + p] = third_derivative_bound(va, aa, qa, 0.0, horizon)
        r[SIZE3 + p] = third_derivative_size(va, aa, qa, 0.0, horizon)
        r[STATUS + p] = INSIDE if f <= 0.0 else SEARCHING


@lean_kernel
def _step_searches(r: Floats, count: int, gravity: float) -> bool:
    """One step of each search that goes on; whether one still does.

    The loop's body is that of `circle_search` without drag, with all cases computed and none
    branched on.
    """
    for p in range(count):
        f = r[F + p]
        fd = r[FD + p]
        h = r[TRUST + p]
        low3 = r[LOW3 + p]
        d2 = r[SQUARE + p]
        horizon = r[SEARCHED + p]
        before = r[S + p]
        status = r[STATUS + p]
        m = r[FDD + p] + low3 * h * THIRD
        square = fd * fd
        fm = f * m
        step = 2.0 * f * fd / (fm - (square + square))
        is_free = (square < fm + fm) | (step > h)
        is_out = is_free & (before + h >= horizon)
        enough = NEGLIGIBLE * d2
        change = r[SIZE3 + p] * step - low3 * h
        is_near = (change * step * step <= 3.0 * enough) & (f * fm * fm <= enough * square * square)
        step = h if is_free else step
        h = h + h if is_free else step
        s = before + step
        psi = 0.5 * s * s
        ux = r[SPEED_X + p]
        uy = r[SPEED_Y + p] + gravity * s
        px = r[FROM_X + p] + ux * s
        py = r[FROM_Y + p] + r[SPEED_Y + p] * s + gravity * psi
        f = px * px + py * py - d2
        rest = horizon - s
        is_hit = ((not is_free) & is_near) | (s == before) | (f <= 0.0)
        is_over = is_out | ((not is_hit) & (h > rest) & (rest <= 0.0))
        found = MISS if is_over else (HIT if is_hit else SEARCHING)
        found = RISES if fd >= 0.0 else found
        goes_on = status == SEARCHING
        r[S + p] = s if goes_on else before
        r[STATUS + p] = found if goes_on else status
        r[F + p] = f
        r[FD + p] = 2.0 * (px * ux + py * uy)
        r[FDD + p] = 2.0 * (ux * ux + uy * uy + py * gravity)
        r[TRUST + p] = rest if h > rest else h
    left = 0.0
    for p in range(count):
        left += 1.0 if r[STATUS + p] == SEARCHING else 0.0
    return left > 0.0


@lean_kernel
def _search_alone(r: Floats, p: int, gravity: float, best: float) -> float:
    """`circle_search` of one search, from its start."""
    qx = r[FROM_X + p]
    qy = r[FROM_Y + p]
    vx = r[SPEED_X + p]
    vy = r[SPEED_Y + p]
    d2 = r[SQUARE + p]
    f = qx * qx + qy * qy - d2
    fd = 2.0 * (qx * vx + qy * vy)
    fdd = 2.0 * (vx * vx + vy * vy + qy * gravity)
    motion = Motion(qx, qy, vx, vy, 0.0, gravity, 0.0)
    return circle_search(motion, d2, r[SEARCHED + p], best, 0.0, f, fd, fdd, r[LOW3 + p])


@lean_kernel
def _keep_first(board: BoardArrays, space: Space, count: int) -> None:
    """Of all that the balls would hit, note what each hits first."""
    w, m, r, whose, which, _, _, _ = space
    items = board.items
    radius = board.radius
    gravity = board.gravity
    for p in range(count):
        i = int(whose[p])
        other = int(which[p])
        status = r[STATUS + p]
        best = w[lanes.BEST + i]
        s = r[S + p] if status == HIT else NO_HIT
        side = 0.0
        if r[SQUARE + p] == 0.0:
            origin = m[lanes.ORIGIN + i]
            s, side = wall_hit(
                items, other, origin, FREE if origin < 0 else BOUNCED, radius,
                Motion(
                    w[lanes.WX + i], w[lanes.WY + i], w[lanes.WVX + i], w[lanes.WVY + i],
                    0.0, gravity, 0.0,
                ),
                w[lanes.HORIZON + i], best,
            )  # fmt: skip
        elif status >= RISES:
            if status == INSIDE:
                m[lanes.ODD + i] = 1
            else:
                s = _search_alone(r, p, gravity, best)
        item = m[lanes.ITEM + i]
        if s != NO_HIT and (s < best or item == NOWHERE or (s == best and other < item)):
            w[lanes.BEST + i] = s
            m[lanes.ITEM + i] = other
            w[lanes.HIT_SIDE + i] = side


@lean_kernel
def search_marked(board: BoardArrays, space: Space, count: int, slots: int) -> None:
    """Note what the balls in the lanes marked[:count] hit first of the surfaces of their cells."""
    r = space.r
    at = 0
    while at < count:
        at, length = _list_marked(board, space, at, count, slots)
        _open_searches(board, space, length)
        full = (length + WIDTH - 1) // WIDTH * WIDTH
        for p in range(length, full):
            r[STATUS + p] = MISS
        for _ in range(MAX_STEPS):
            if not _step_searches(r, full, board.gravity):
                break
        _keep_first(board, space, length)
