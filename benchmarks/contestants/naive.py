"""The physics engine of game tutorials, compiled.

Semi-implicit Euler with one step per frame: first v, then x with the new v. After the move,
overlaps are found in a grid whose cells are two of the largest diameters wide. The impulse is
j = -(1 + e) v_n m. Friction is min(mu j, the impulse that stops the tangential velocity), without
spin, which these tutorials leave out. Drag is the factor 1 - k dt. 60 % of an overlap is corrected
at once.
"""

import numpy as np
import numpy.typing as npt
from numba import njit

from benchmarks.contestants.common import (
    LONGEST,
    Contestant,
    Floats,
    Paths,
    pairs,
    poll_steps,
    steps_of,
)
from benchmarks.harness.clock import seconds_of
from plinko.engine import Board

CORRECTION = 0.6  # share of an overlap; the tutorials' values are 0.4 to 0.8
Ints = npt.NDArray[np.int64]


class _Grid:
    """Pegs and walls, and for each cell those that a ball in it may touch."""

    def __init__(self, board: Board) -> None:
        reach = board.ball.radius
        largest = max([reach, *(peg.radius for peg in board.pegs)])
        self.cell = 4.0 * largest
        pegs = [(p.x, p.y, p.x, p.y, p.radius + reach, 0.0) for p in board.pegs]
        walls = [(w.x1, w.y1, w.x2, w.y2, reach, 1.0) for w in board.walls]
        self.bodies = np.array(pegs + walls, np.float64).reshape(-1, 6)
        low = self.bodies[:, [0, 1]].min(axis=0), self.bodies[:, [2, 3]].min(axis=0)
        high = self.bodies[:, [0, 1]].max(axis=0), self.bodies[:, [2, 3]].max(axis=0)
        self.x0, self.y0 = np.minimum(*low) - 2.0 * self.cell
        top = np.maximum(*high) + 2.0 * self.cell
        self.columns = int((top[0] - self.x0) / self.cell) + 1
        self.rows = int((top[1] - self.y0) / self.cell) + 1
        self.starts, self.members = self._fill()

    def _fill(self) -> tuple[Ints, Ints]:
        lists: list[list[int]] = [[] for _ in range(self.columns * self.rows)]
        for number, (x1, y1, x2, y2, reach, _) in enumerate(self.bodies.tolist()):
            left = int((min(x1, x2) - reach - self.x0) / self.cell)
            right = int((max(x1, x2) + reach - self.x0) / self.cell)
            upper = int((min(y1, y2) - reach - self.y0) / self.cell)
            lower = int((max(y1, y2) + reach - self.y0) / self.cell)
            for row in range(max(upper, 0), min(lower, self.rows - 1) + 1):
                for column in range(max(left, 0), min(right, self.columns - 1) + 1):
                    lists[row * self.columns + column].append(number)
        starts = np.cumsum([0, *(len(cell) for cell in lists)]).astype(np.int64)
        return starts, np.array([n for cell in lists for n in cell], np.int64)


@njit(nogil=True, error_model="numpy")
def _advance(
    r: Floats,
    v: Floats,
    steps: int,
    dt: float,
    gravity: float,
    drag: float,
    material: Floats,
    bodies: Floats,
    starts: Ints,
    members: Ints,
    frame: Floats,
    shape: tuple[int, int],
) -> None:
    """Advance all balls by `steps` steps; r and v have the shape (n, 2).

    The grid is given by frame = (x0, y0, cell size) and shape = (columns, rows).
    """
    columns, rows = shape
    keep = 1.0 - drag * dt
    for _ in range(steps):
        for i in range(r.shape[0]):
            v[i, 1] += gravity * dt
            v[i, 0] *= keep
            v[i, 1] *= keep
            r[i, 0] += v[i, 0] * dt
            r[i, 1] += v[i, 1] * dt
            column = int(np.floor((r[i, 0] - frame[0]) / frame[2]))
            row = int(np.floor((r[i, 1] - frame[1]) / frame[2]))
            if not (0 <= column < columns and 0 <= row < rows):
                continue
            cell = row * columns + column
            for k in range(starts[cell], starts[cell + 1]):
                body = bodies[members[k]]
                cx = body[0]
                cy = body[1]
                wx = body[2] - cx
                wy = body[3] - cy
                if body[5] > 0.0:
                    along = ((r[i, 0] - cx) * wx + (r[i, 1] - cy) * wy) / (wx * wx + wy * wy)
                    along = min(max(along, 0.0), 1.0)
                    cx += along * wx
                    cy += along * wy
                dx = r[i, 0] - cx
                dy = r[i, 1] - cy
                apart = np.sqrt(dx * dx + dy * dy)
                if apart >= body[4] or apart == 0.0:
                    continue
                nx = dx / apart
                ny = dy / apart
                kind = int(body[5])
                vn = v[i, 0] * nx + v[i, 1] * ny
                if vn < 0.0:
                    j = -(1.0 + material[kind, 0]) * vn
                    v[i, 0] += j * nx
                    v[i, 1] += j * ny
                    vt = v[i, 1] * nx - v[i, 0] * ny
                    limit = material[kind, 1] * j
                    jt = min(max(-vt, -limit), limit)
                    v[i, 0] -= jt * ny
                    v[i, 1] += jt * nx
                push = CORRECTION * (body[4] - apart)
                r[i, 0] += push * nx
                r[i, 1] += push * ny


class Naive(Contestant):
    name = "naive Euler"

    def seconds(self, board: Board, xs: Floats, dt: float) -> float:
        grid = _Grid(board)
        r, v = _start(board, xs)
        self._run(board, grid, r[:1].copy(), v[:1].copy(), 1, dt)  # compiles

        def work() -> None:
            for _ in range(int(LONGEST / dt) // poll_steps(dt)):
                self._run(board, grid, r, v, poll_steps(dt), dt)
                if (r[:, 1] >= board.bins.y).all():
                    return

        return seconds_of(work)

    def paths(self, board: Board, xs: Floats, dt: float, duration: float) -> Paths:
        grid = _Grid(board)
        r, v = _start(board, xs)
        positions, velocities = [r.copy()], [v.copy()]
        for _ in range(steps_of(duration, dt)):
            self._run(board, grid, r, v, 1, dt)
            positions.append(r.copy())
            velocities.append(v.copy())
        return Paths(dt, np.array(positions), np.array(velocities))

    @staticmethod
    def _run(board: Board, grid: _Grid, r: Floats, v: Floats, steps: int, dt: float) -> None:
        peg, wall = pairs(board)
        material = np.array([[peg.restitution, peg.friction], [wall.restitution, wall.friction]])
        frame = np.array([grid.x0, grid.y0, grid.cell])
        _advance(
            r, v, steps, dt, board.gravity, board.drag, material,
            grid.bodies, grid.starts, grid.members, frame, (grid.columns, grid.rows),
        )  # fmt: skip


def _start(board: Board, xs: Floats) -> tuple[Floats, Floats]:
    r = np.column_stack([xs, np.full(len(xs), board.drop.y)])
    return r, np.zeros_like(r)
