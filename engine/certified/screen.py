"""Screens a board's surfaces in double precision: which a ball may touch, and not before when.

The margins here are far above float64's rounding, so the screen never omits a surface that the
ball touches. What remains is decided in ball arithmetic.
"""

from math import exp, nextafter
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from flint import arb

from plinko.engine.board.fields import BoardFields
from plinko.engine.certified.balls import UndecidedError
from plinko.engine.certified.reach import MARGIN, NEVER, first_reaches
from plinko.engine.certified.surfaces import Circle, Face, Surface

Array = npt.NDArray[np.float64]

_STRAIGHT = 40.0
"""Drag times a time after which a flight is straight: e^-40 of the acceleration is left. Windows of
the search may then be longer than drag allows."""


class Course(NamedTuple):
    """A flight in double precision: x, y, v_x, v_y, a_x, a_y at its start, in m and s, the drag in
    1/s, and bounds of the errors of position, velocity and acceleration."""

    state: Array
    drag: float
    errors: Array

    @classmethod
    def of(cls, parts: tuple[arb, ...], drag: arb) -> "Course":
        """The course whose six numbers have these enclosures."""
        x, y, vx, vy, ax, ay = [float(part.rad()) for part in parts]
        widths = x + y, vx + vy, ax + ay
        errors = np.array([nextafter(1.000001 * width, NEVER) for width in widths])
        return cls(np.array([float(part) for part in parts]), float(drag), errors)

    def straight_after(self, start: float) -> "Course":
        """The same flight from `start` on, as straight motion: drag has ended all acceleration.

        The acceleration a e^(-ks) that is left moves the ball by at most a e^(-ks) / k^2, which is
        added to the errors.
        """
        x, y, vx, vy, ax, ay = self.state.tolist()
        k, (far, fast, pull) = self.drag, self.errors.tolist()
        phi = 1.0 / k
        psi = (start - phi) / k
        left = 2.0 * exp(-k * start) * (abs(ax) + abs(ay)) / k
        state = x + vx * start + ax * psi, y + vy * start + ay * psi, vx + ax * phi, vy + ay * phi
        errors = far + start * (fast + 0.5 * start * pull) + left / k, fast + start * pull, pull
        return Course(np.array([*state, 0.0, 0.0]), 0.0, np.array(errors))


class Reaches(NamedTuple):
    """The surfaces that the ball may touch up to `end`, each with a time in s before which it does
    not, sorted by these times. None is the bins' line. `end` is NEVER if the ball leaves the board.
    """

    found: list[tuple[float, Surface | None]]
    end: float


class Screen:
    """The positions of all surfaces of a board as float64."""

    def __init__(self, circles: list[Circle], faces: list[Face], board: BoardFields) -> None:
        self._surfaces: list[Surface | None] = [*circles, *faces, None]
        self._numbers = {surface: i for i, surface in enumerate(self._surfaces)}
        rows = [(float(c.x), float(c.y), float(c.reach)) for c in circles]
        self._circles = np.array(rows).reshape(-1, 3)
        lines = [(*map(float, (f.x, f.y, f.nx, f.ny, f.reach)), *_between(f)) for f in faces]
        self._lines = np.array(lines).reshape(-1, 7)
        left, right, top, _ = board.extent
        smallest = min((row[2] for row in rows), default=board.ball.radius)
        beyond = max(right - left, board.bins.y - top)
        box = left - beyond, right + beyond, top - beyond
        size = float(np.abs(np.array([1.0, *box, *self._circles.ravel()])).max()) + beyond
        self._board = np.array([smallest, size, *box, board.bins.y])
        self._margin = MARGIN * size
        count = len(self._surfaces)
        self._found = np.empty(count, np.int64), np.empty(count)

    def reaches(self, course: Course, start: float, left: Surface | None) -> Reaches:
        """The surfaces that the ball may touch in the window that begins `start` s into a flight.

        If `start` is not 0, empty windows are skipped. The window at 0 leaves out the surface
        `left`, which the ball has just left: the caller searches that one itself.
        """
        if course.drag * start > _STRAIGHT:
            found, end = self.reaches(course.straight_after(start), 0.0, None)
            return Reaches([(start + time, each) for time, each in found], start + end)
        numbers, times = self._found
        number = -1 if left is None else self._numbers[left]
        count, end = first_reaches(
            course.state, course.drag, course.errors, start, number, self._circles, self._lines,
            self._board, numbers, times,
        )  # fmt: skip
        if count < 0 and course.drag * end > _STRAIGHT:
            return self.reaches(course, end, None)  # nothing is touched before
        if count < 0:
            raise UndecidedError("whether a flight ends")
        order = sorted(zip(times[:count].tolist(), numbers[:count].tolist(), strict=True))
        return Reaches([(time, self._surfaces[which]) for time, which in order], end)

    def near(self, a: tuple[float, float], b: tuple[float, float], bulge: float) -> list[Surface]:
        """The surfaces that a path within `bulge` m of the chord from a to b may touch."""
        return [s for i in self._near(a, b, bulge) if (s := self._surfaces[i]) is not None]

    def _near(self, a: tuple[float, float], b: tuple[float, float], bulge: float) -> list[int]:
        place, line, slack = self._circles, self._lines, bulge + self._margin
        qx, qy = place[:, 0] - a[0], place[:, 1] - a[1]
        ex, ey = b[0] - a[0], b[1] - a[1]
        square = ex * ex + ey * ey
        if square > 0.0:
            share = np.clip((qx * ex + qy * ey) / square, 0.0, 1.0)
            qx, qy = qx - share * ex, qy - share * ey
        limit = place[:, 2] + slack
        close = np.flatnonzero(qx * qx + qy * qy < limit * limit)
        at_a = (a[0] - line[:, 0]) * line[:, 2] + (a[1] - line[:, 1]) * line[:, 3] - line[:, 4]
        at_b = (b[0] - line[:, 0]) * line[:, 2] + (b[1] - line[:, 1]) * line[:, 3] - line[:, 4]
        crossed = (np.minimum(at_a, at_b) < slack) & (np.maximum(at_a, at_b) > -slack)
        return [*close.tolist(), *(len(place) + np.flatnonzero(crossed)).tolist()]


def _between(face: Face) -> tuple[float, float]:
    """Where the face ends and where it begins along (-n_y, n_x), in m from its first point."""
    length = float(face.length)
    ahead = float(face.ny * -face.tx + face.nx * face.ty) < 0.0
    return (length, 0.0) if not ahead else (0.0, -length)
