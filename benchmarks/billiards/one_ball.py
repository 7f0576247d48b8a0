"""The full path of one ball of a billiard up to an instant, with rolling and sliding."""

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from benchmarks.billiards.billiard import Billiard
from benchmarks.billiards.flow import MAX_SPEED, MAX_TIME
from plinko.engine.board.form import MAX_COORDINATE
from plinko.engine.drops.trajectory import Trajectory, follow
from plinko.engine.errors import ParameterError
from plinko.engine.exact.outcome import EVENT_LIMIT, MAX_EVENTS, TIME_LIMIT
from plinko.engine.parameters import Exact, number
from plinko.engine.physics import body

_FIRST_EVENTS = 256


def path(
    billiard: Billiard,
    place: tuple[float, float],
    velocity: tuple[float, float],
    until: float,
    *,
    spin: float = 0.0,
    max_events: int = MAX_EVENTS,
) -> Trajectory:
    """Follow one ball from `place` (m) with `velocity` (m/s) and `spin` (rad/s) to `until` (s).

    The exact solver computes flight, impacts, rolling and sliding. The path ends earlier if the
    ball comes to rest or after `max_events`; its `outcome` says which. Raises ParameterError for a
    number out of range and for a billiard that repeats, in which only `launch` follows balls.
    """
    if billiard.cell is not None:
        raise ParameterError(
            "a path needs an open billiard, and this one repeats (`cell`): use `launch` instead",
            field="billiard",
        )
    start = np.zeros(body.SIZE)
    start[body.X] = number(place[0], "place[0]", -MAX_COORDINATE, MAX_COORDINATE)
    start[body.Y] = number(place[1], "place[1]", -MAX_COORDINATE, MAX_COORDINATE)
    start[body.VX] = number(velocity[0], "velocity[0]", -MAX_SPEED, MAX_SPEED)
    start[body.VY] = number(velocity[1], "velocity[1]", -MAX_SPEED, MAX_SPEED)
    start[body.OMEGA] = number(spin, "spin", -MAX_SPEED, MAX_SPEED)
    until = number(until, "until", 0.0, MAX_TIME)
    found = _followed(billiard, start, until, max_events)
    passed = found.outcome == TIME_LIMIT or found.end[body.T] > until
    return _cut(found, until) if passed else found


def _followed(
    billiard: Billiard, start: npt.NDArray[np.float64], until: float, max_events: int
) -> Trajectory:
    """The path to `until` and somewhat beyond.

    The solver checks the time only after a stretch of flight without impacts, and a ball in a
    narrow gap has no such stretch. The limit of events is therefore raised until the path is long
    enough.
    """
    events = min(_FIRST_EVENTS, max_events)
    while True:
        found = follow(billiard.fields, start, Exact(), events, until)
        if found.outcome != EVENT_LIMIT or found.end[body.T] > until or events == max_events:
            return found
        events = min(4 * events, max_events)


def _cut(path: Trajectory, until: float) -> Trajectory:
    """Cut a path at `until`; its last flight must reach that time."""
    events = int(np.searchsorted(path.impacts["t"], until, side="right"))
    segments = int(np.searchsorted(path.segments[:, body.T], until, side="right"))
    far = path.end.copy()
    far[body.T] = np.inf
    end: npt.NDArray[np.float64] = replace(path, end=far).states_at(np.array([until]))[0]
    return replace(
        path,
        outcome=TIME_LIMIT,
        bin=-1,
        end=end,
        impacts=path.impacts[:events],
        segments=path.segments[:segments],
    )
