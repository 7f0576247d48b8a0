"""The binary messages of `?stream=segments`: when each segment is sent, and its bytes. Pure.

docs/protocol.md describes every byte. Times on the wire are rounded to steps of a tick. A segment's
state is that of the ball at the rounded time, so rounding does not displace the ball.
"""

import math
import struct
from dataclasses import dataclass, field

from app.protocol.messages import Extent
from app.protocol.path import UNDER_WAY, Segment, cut, later
from engine.drops.trajectory import Trajectory
from engine.exact.outcome import RUNNING
from engine.physics import body

MAGIC = 0x53
VERSION = 2
HEADER = struct.Struct("<BBHIIHBB")  # magic, version, flights, tick, seq, curves, flags, 0
FULL = 1  # flag: the message has the current segment of every ball in flight

FLIGHT = struct.Struct("<HBBHHHhhhH")  # id, kind, angle, age, x, y, vx, vy, spin, index
CURVE = struct.Struct("<HBBHHHhhhHff")  # the same fields, then ax, ay

_TURN = 256
_TOP = 32767
_GRID = 65535
_STEPS = 1024  # steps of a tick: rounding shifts a beginning by up to half a step, 8 us at 60 Hz
_OLDEST = 63  # ticks; a segment that began longer ago is sent from there on


@dataclass(frozen=True, slots=True)
class Scale:
    """The scales and constants that decode a message, as in the hello; SI units, ticks a second."""

    extent: Extent
    velocity_scale: float
    spin_scale: float
    tick_rate: int
    gravity: float
    drag: float

    def law(self) -> dict[str, float]:
        """Gravity in m/s^2 and drag in 1/s, as arguments of `later`."""
        return {"gravity": self.gravity, "drag": self.drag}


@dataclass(frozen=True, slots=True)
class _Due:
    """A segment, the room's tick at which it is due, and its beginning in ticks."""

    tick: int
    begin: float
    segment: Segment


@dataclass(slots=True)
class _Course:
    """One ball's path, as far as it has been cut."""

    start_tick: int
    sent: int  # clients have all segments that were due up to this tick
    cut: int = 0  # number of the path's rows that have been cut
    known: float = 0.0  # s since the ball's start; infinite if all of the path is cut
    rows: list[_Due] = field(default_factory=list)  # from the current segment on

    def at(self, tick: int) -> _Due | None:
        """The ball's segment at this tick, if it is known."""
        while len(self.rows) > 1 and self.rows[1].tick <= tick:
            del self.rows[0]
        return self.rows[0] if self.rows else None


class SegmentStream:
    """Schedules the segments of a room's balls; `now` is the room's tick."""

    def __init__(self, scale: Scale, now: int) -> None:
        self._scale = scale
        self._next = now + 1
        self._courses: dict[int, _Course] = {}
        self._due: dict[int, list[_Due]] = {}

    def add(self, ball: int, start_tick: int, now: int) -> None:
        """Add a ball that started at `start_tick`; its segments due after tick `now` will be sent.

        Those of a ball that starts now are all sent.
        """
        self._courses[ball] = _Course(start_tick, now if start_tick < now else -1)

    def needs(self, ball: int, known: float) -> bool:
        """Whether `extend` should be called for a ball whose path is known until `known`, in s.

        It should if more of the path is known, or if no segment is due from the next tick on.
        """
        course = self._courses[ball]
        if course.known == math.inf:
            return False
        return known > course.known or not course.rows or course.rows[-1].tick < self._next

    def extend(self, ball: int, passed: int, path: Trajectory) -> None:
        """Cut the known rows of a ball's path; `passed` earlier rows are not in `path`."""
        course, rate = self._courses[ball], self._scale.tick_rate
        until = (self._next + 1 - course.start_tick) / rate
        pieces, course.cut = cut(path, ball, passed, course.cut, until)
        course.known = float(path.end[body.T]) if path.outcome == RUNNING else math.inf
        for segment in pieces:
            begin = course.start_tick + segment.t * rate
            # Due with the tick that ends at or after its beginning, like the event of its bounce.
            row = _Due(course.start_tick + math.ceil(segment.t * rate), begin, segment)
            course.rows.append(row)
            if row.tick > course.sent:
                self._due.setdefault(max(row.tick, self._next), []).append(row)
        course.at(self._next - 1)

    def forget(self, ball: int) -> None:
        """Remove a ball that has landed."""
        self._courses.pop(ball, None)

    def take(self, tick: int, seq: int) -> bytes | None:
        """A message with the segments that became due up to this tick; None if there are none."""
        rows: list[_Due] = []
        for due in range(self._next, tick + 1):
            rows += self._due.pop(due, ())
        self._next = tick + 1
        return _message(tick, seq, rows, 0, self._scale) if rows else None

    def full(self, tick: int, seq: int) -> bytes:
        """A message with the current segment of every ball."""
        current = (course.at(tick) for course in self._courses.values())
        rows = [row for row in current if row is not None]
        return _message(tick, seq, rows, FULL, self._scale)


def _message(tick: int, seq: int, rows: list[_Due], flags: int, scale: Scale) -> bytes:
    flights = [_record(tick, row, scale) for row in rows if row.segment.bend is None]
    curves = [_record(tick, row, scale) for row in rows if row.segment.bend is not None]
    stamp = (tick & 0xFFFFFFFF, seq & 0xFFFFFFFF)
    header = HEADER.pack(MAGIC, VERSION, len(flights), *stamp, len(curves), flags, 0)
    return b"".join((header, *flights, *curves))


def _record(tick: int, row: _Due, scale: Scale) -> bytes:
    """The bytes of a segment in a message of this tick."""
    age = round((tick - row.begin) * _STEPS)
    kind = row.segment.kind
    if age > _OLDEST * _STEPS:
        age = _OLDEST * _STEPS
        kind = UNDER_WAY
    moved = (tick - age / _STEPS - row.begin) / scale.tick_rate
    segment = later(row.segment, moved, **scale.law())
    box = scale.extent
    turns = segment.angle / (2.0 * math.pi)
    values = (
        segment.ball & 0xFFFF,
        kind,
        round((turns - math.floor(turns)) * _TURN) % _TURN,
        age,
        _clamp((0.5 * (segment.x - box.x_min) / (box.x_max - box.x_min) + 0.25) * _GRID, 0, _GRID),
        _clamp((segment.y - box.y_min) / (box.y_max - box.y_min) * _GRID, 0, _GRID),
        _clamp(segment.vx / (0.5 * scale.velocity_scale), -_TOP, _TOP),
        _clamp(segment.vy / (0.5 * scale.velocity_scale), -_TOP, _TOP),
        _clamp(segment.spin / scale.spin_scale, -_TOP, _TOP),
        segment.index & 0xFFFF,
    )
    return FLIGHT.pack(*values) if segment.bend is None else CURVE.pack(*values, *segment.bend)


def _clamp(value: float, low: int, high: int) -> int:
    return round(min(max(value, low), high))
