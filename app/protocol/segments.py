"""Binary messages of `?stream=segments`: which segments are sent when, and as which bytes. Pure.

docs/protocol.md describes every byte. Times on the wire are in steps of a tick; a segment is told
from where the ball is at such a step, so that rounding its time moves nothing.
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
FULL = 1  # flag: the current segment of every ball in flight, whatever came before

FLIGHT = struct.Struct("<HBBHHHhhhH")  # id, kind, angle, age, x, y, vx, vy, spin, index
CURVE = struct.Struct("<HBBHHHhhhHff")  # the same and ax, ay

_TURN = 256
_TOP = 32767
_GRID = 65535
_STEPS = 1024  # of a tick: a segment may begin up to half a step, 8 us at 60 Hz, too soon or late
_OLDEST = 63  # ticks; a segment that began longer ago is told from there


@dataclass(frozen=True, slots=True)
class Scale:
    """What the numbers of a message mean: the hello tells it all. SI units, ticks a second."""

    extent: Extent
    velocity_scale: float
    spin_scale: float
    tick_rate: int
    gravity: float
    drag: float

    def law(self) -> dict[str, float]:
        """Gravity in m/s^2 and drag in 1/s by name."""
        return {"gravity": self.gravity, "drag": self.drag}


@dataclass(frozen=True, slots=True)
class _Due:
    """A segment on its way: the room's tick at which it is due, and when it begins, in ticks."""

    tick: int
    begin: float
    segment: Segment


@dataclass(slots=True)
class _Course:
    """One ball's path, as far as it was cut."""

    start_tick: int
    told: int  # what was due up to this tick is known to all who watch
    cut: int = 0  # rows of the path
    known: float = 0.0
    rows: list[_Due] = field(default_factory=list)  # from that on which the ball is

    def at(self, tick: int) -> _Due | None:
        """The segment that the ball is on at this tick, if it is known."""
        while len(self.rows) > 1 and self.rows[1].tick <= tick:
            del self.rows[0]
        return self.rows[0] if self.rows else None


class SegmentStream:
    """What of each ball's path is to be sent at which tick of a room; `now` is the room's tick."""

    def __init__(self, scale: Scale, now: int) -> None:
        self._scale = scale
        self._next = now + 1
        self._courses: dict[int, _Course] = {}
        self._due: dict[int, list[_Due]] = {}

    def add(self, ball: int, start_tick: int, now: int) -> None:
        """Follow a ball: what begins after tick `now`, or at a start that is now, will be sent."""
        self._courses[ball] = _Course(start_tick, now if start_tick < now else -1)

    def hears(self, ball: int, known: float) -> bool:
        """Whether `extend` would bring news of a ball whose path is known up to a time, in s.

        That is the case too when something has to be told before all of it is known.
        """
        course = self._courses[ball]
        if course.known == math.inf:
            return False
        return known > course.known or not course.rows or course.rows[-1].tick < self._next

    def extend(self, ball: int, passed: int, path: Trajectory) -> None:
        """Take what is known of a ball's path; `passed` rows of it lie before the trajectory's."""
        course, rate = self._courses[ball], self._scale.tick_rate
        until = (self._next + 1 - course.start_tick) / rate
        pieces, course.cut = cut(path, ball, passed, course.cut, until)
        course.known = float(path.end[body.T]) if path.outcome == RUNNING else math.inf
        for segment in pieces:
            begin = course.start_tick + segment.t * rate
            # The tick that ends when or after the segment begins, as for its bounce's event.
            row = _Due(course.start_tick + math.ceil(segment.t * rate), begin, segment)
            course.rows.append(row)
            if row.tick > course.told:
                self._due.setdefault(max(row.tick, self._next), []).append(row)
        course.at(self._next - 1)

    def forget(self, ball: int) -> None:
        """A ball has landed."""
        self._courses.pop(ball, None)

    def take(self, tick: int, seq: int) -> bytes | None:
        """The message of all that became due up to this tick; None when nothing did."""
        rows: list[_Due] = []
        for due in range(self._next, tick + 1):
            rows += self._due.pop(due, ())
        self._next = tick + 1
        return _message(tick, seq, rows, 0, self._scale) if rows else None

    def full(self, tick: int, seq: int) -> bytes:
        """The message of the segment that every ball is on at this tick."""
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
    """A segment as bytes in a message of this tick."""
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
