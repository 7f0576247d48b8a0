"""Find the walls that are a board's sides, as static/js/model/board.js does for the page.

A wall has no thickness. The rail of a side wall is painted outside, so that balls touch its edge.
An inner wall has balls on both sides, and its rail is centred on it.
"""

import functools
from collections.abc import Iterator

from plinko.engine import Board

Point = tuple[float, float]


@functools.lru_cache(maxsize=4)
def sides_of(board: Board) -> tuple[int, ...]:
    """For each wall: -1 at the left side, 1 at the right side, 0 inside.

    A side is a chain of walls with common ends that leads down to an outer end of the bins.
    """
    found = [0] * len(board.walls)
    for chain in _chains(board):
        ends = {end for wall in chain if (end := _end_reached(board, wall))}
        for wall in chain:
            if len(ends) == 1:
                (found[wall],) = ends
            elif ends:
                middle = board.walls[wall].x1 + board.walls[wall].x2 - 2.0 * board.drop.x
                found[wall] = (middle > 0.0) - (middle < 0.0)
    return tuple(found)


def _end_reached(board: Board, number: int) -> int:
    """The outer end of the bins (-1 or 1) that a wall reaches within a ball's radius; else 0."""
    wall, bins, near = board.walls[number], board.bins, board.ball.radius
    top, bottom = sorted(((wall.y1, wall.x1), (wall.y2, wall.x2)))
    if not top[0] <= bins.y <= bottom[0] + near:
        return 0
    part = min((bins.y - top[0]) / (bottom[0] - top[0]), 1.0) if bottom[0] > top[0] else 1.0
    x = top[1] + part * (bottom[1] - top[1])
    return (x >= bins.edges[-1] - near) - (x <= bins.edges[0] + near)


def _chains(board: Board) -> Iterator[list[int]]:
    """Yield the chains of walls that share ends, as lists of wall numbers."""
    meeting: dict[Point, list[int]] = {}
    for number, wall in enumerate(board.walls):
        for end in ((wall.x1, wall.y1), (wall.x2, wall.y2)):
            meeting.setdefault(end, []).append(number)
    left = dict.fromkeys(range(len(board.walls)))
    while left:
        chain = [next(iter(left))]
        del left[chain[0]]
        for number in chain:  # the loop appends to the list it iterates over
            wall = board.walls[number]
            for end in ((wall.x1, wall.y1), (wall.x2, wall.y2)):
                for other in meeting[end]:
                    if other in left:
                        del left[other]
                        chain.append(other)
        yield chain
