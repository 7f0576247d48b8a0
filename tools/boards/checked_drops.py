"""Checks every drop of a batch against geometry and energy, computed here from the board's numbers.

What has to hold on every valid board, whatever the path:

    off its body      At every impact and contact event the ball touches the body that it names.
    depth             The ball is never deeper than rounding in any peg or wall.
    rides on nothing  A ball that rolls or slides touches something.
    hits inwards      After an impact the ball does not move into the body that it has hit.
    jump              The place is continuous where one law of motion follows another.
    energy            Translation, rotation and height together never gain energy.
    rests on nothing  A ball that lies still touches a body below it, or two.
    batch             A batch has the same result, to the last bit.
    ... budget        The drop ends.

Only the motion between events comes from the engine (`states_at`). Distances are those of points
from segments and circles, so a fault of the engine's own geometry cannot hide itself.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import KIND_LANDING, KIND_PEG, KIND_WALL
from plinko.engine.drops.batch import drop_many
from plinko.engine.drops.certainty import certainty_of
from plinko.engine.drops.trajectory import Trajectory, at_start, follow
from plinko.engine.exact import event_log
from plinko.engine.exact.outcome import (
    BALANCED,
    EVENT_LIMIT,
    LANDED,
    REASONS,
    TIME_LIMIT,
    WEDGED,
)
from plinko.engine.parameters import Exact
from plinko.engine.physics import body
from plinko.engine.seeding import start_xs

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.intp]

SAMPLES: Final = 300
"""Times at which a drop is sampled: half of them even in time, half of them even over the pieces of
the path, so that short flights are seen too."""

MOST: Final = 3000
"""Events and pieces of a path that are looked at one by one; a path that has more is endless."""

NEAR: Final = 1e-9
"""Largest error of a distance, in radii of the ball."""

ALIKE: Final = 1e-9
"""m; largest distance between the ends of two drops over the same surface."""

GAIN: Final = 1e-11
"""Largest gain of energy, as a share of the energy of a fall through the board."""

INWARDS: Final = 1e-6
"""m/s; largest speed into a body that has just been hit."""

LIVELY: Final = 0.9
"""A ball of a greater restitution may use up its events."""

HEAVY_DRAG: Final = 5.0
"""1/s; with more drag a ball may still roll down a gentle slope when its time is over."""


@dataclass(frozen=True)
class Failure:
    """A drop that breaks a law: board number, start in m, and where it does so first."""

    kind: str
    number: int
    x: float
    t: float
    what: str

    def __str__(self) -> str:
        return f"board {self.number}, x = {self.x!r}, t = {self.t!r}: {self.what}"


class Bodies:
    """All pegs, then all walls of a board, and distances of points from them."""

    def __init__(self, board: Board) -> None:
        pegs = np.array([(p.x, p.y, p.radius) for p in board.pegs]).reshape(-1, 3)
        walls = np.array([(w.x1, w.y1, w.x2, w.y2) for w in board.walls]).reshape(-1, 4)
        self.pegs = len(pegs)
        self.radius = board.ball.radius
        self.start = np.concatenate((pegs[:, :2], walls[:, :2]))
        self.along = np.concatenate((np.zeros((self.pegs, 2)), walls[:, 2:] - walls[:, :2]))
        self.square = np.maximum((self.along**2).sum(axis=1), 1e-300)
        self.reach = self.radius + np.concatenate((pegs[:, 2], np.zeros(len(walls))))

    def offsets(self, points: Floats, bodies: Ints) -> Floats:
        """Vectors from the nearest points of `bodies`, shape (n,), to `points`, shape (n, 2)."""
        apart, along = points - self.start[bodies], self.along[bodies]
        share = np.clip((apart * along).sum(axis=1) / self.square[bodies], 0.0, 1.0)
        result: Floats = apart - share[:, None] * along
        return result

    def gaps(self, points: Floats) -> Floats:
        """Distances of n points from the surface of each of m bodies, (n, m); negative inside."""
        dx = points[:, :1] - self.start[:, 0]
        dy = points[:, 1:] - self.start[:, 1]
        ux, uy = self.along.T
        share = np.clip((dx * ux + dy * uy) / self.square, 0.0, 1.0)
        dx -= share * ux
        dy -= share * uy
        result: Floats = np.sqrt(dx * dx + dy * dy) - self.reach
        return result

    def name(self, number: int) -> str:
        return f"peg {number}" if number < self.pegs else f"wall {number - self.pegs}"


@dataclass(frozen=True)
class _Sampled:
    """States of many drops one after the other, shape (n, 7), and the number of each one's drop.

    rides: whether the ball rolls or slides there. before: rows right before a new piece of a path,
    which the next row begins.
    """

    states: Floats
    owner: Ints
    rides: npt.NDArray[np.bool_]
    before: Ints


def _sample(paths: list[Trajectory]) -> _Sampled:
    states, owner, rides, before = [], [], [], []
    rows = 0
    for number, path in enumerate(paths):
        times, ends = _times(path)
        some = path.states_at(times)
        states.append(some)
        owner.append(np.full(len(times), number))
        piece = np.searchsorted(path.segments[:, body.T], times, side="right") - 1
        rides.append(path.segments[piece, event_log.ITEM] >= 0.0)
        before.append(rows + ends)
        rows += len(times)
    return _Sampled(
        np.concatenate(states), np.concatenate(owner), np.concatenate(rides), np.concatenate(before)
    )


def _times(path: Trajectory) -> tuple[Floats, Ints]:
    """Increasing times, and the rows of those right before a piece begins (the next row)."""
    end = path.end[body.T]
    begins = np.unique(path.segments[path.segments[:, body.T] < end, body.T])
    even = np.linspace(0.0, end, SAMPLES // 2, endpoint=False)
    begins = begins[:MOST]
    share = np.linspace(0.0, len(begins), SAMPLES // 2, endpoint=False)
    piece = share.astype(np.intp)
    inner = begins[piece] + (share - piece) * (np.append(begins[1:], end) - begins)[piece]
    befores = np.nextafter(begins[1:], -np.inf)
    times = np.concatenate((even, inner, begins, befores))
    times = np.unique(times[(times >= 0.0) & (times < end)])
    return times, np.searchsorted(times, begins[1:]) - 1


def check_paths(board: Board, paths: list[Trajectory], number: int = 0) -> list[Failure]:
    """The first failure of each kind of each path."""
    found: dict[tuple[int, str], Failure] = {}
    bodies = Bodies(board)
    sampled = _sample(paths)
    for drop, kind, t, what in (
        *_budgets(board, paths),
        *_events(bodies, paths),
        *_places(bodies, sampled),
        *_jumps(bodies, sampled),
        *_energies(board, paths, sampled),
        *_rests(bodies, paths),
    ):
        x = float(paths[drop].start[body.X])
        found.setdefault((drop, kind), Failure(kind, number, x, t, what))
    return list(found.values())


def check_drops(board: Board, seeds: Iterable[int], number: int = 0) -> list[Failure]:
    """The failures of the drops of these seeds; `number` is only for the report."""
    xs = start_xs(np.array(list(seeds), np.uint64), board.drop.x, board.drop.jitter)
    return check_starts(board, xs.tolist(), number)


def check_starts(board: Board, xs: Iterable[float], number: int = 0) -> list[Failure]:
    """The failures of the drops from these starts in m."""
    paths = [follow(board, at_start(board, x), Exact()) for x in xs]
    return check_paths(board, paths, number) + compare_batch(board, paths, number)


def compare_batch(board: Board, paths: list[Trajectory], number: int = 0) -> list[Failure]:
    """The paths to which a batch of the same starts has another result."""
    starts = np.array([path.start[body.X] for path in paths])
    batch = drop_many(board, len(starts), xs=starts, threads=1)
    landed = [path.outcome == LANDED for path in paths]
    ends = np.array([(path.end[body.T], path.end[body.X]) for path in paths])
    same = batch.outcome == [path.outcome for path in paths]
    same &= batch.bin == np.where(landed, [path.bin for path in paths], -1)
    same &= (batch.duration == ends[:, 0]) & (batch.x_end == ends[:, 1])
    return [
        Failure("batch", number, float(starts[i]), float(ends[i, 0]), "a batch ends differently")
        for i in np.flatnonzero(~same).tolist()
    ]


def compare_drops(whole: Board, cut: Board, seeds: Iterable[int], number: int = 0) -> list[Failure]:
    """The drops of these seeds that end elsewhere on `cut`, a board with the same surface.

    A drop is compared only if rounding cannot have moved its end on `whole` by ALIKE.
    """
    found = []
    xs = start_xs(np.array(list(seeds), np.uint64), whole.drop.x, whole.drop.jitter)
    for x in xs.tolist():
        one, other = (follow(board, at_start(board, x), Exact()) for board in (whole, cut))
        x_one, x_other = float(one.end[body.X]), float(other.end[body.X])
        if one.outcome == other.outcome and one.bin == other.bin and abs(x_one - x_other) <= ALIKE:
            continue
        if not is_sure(one):
            continue
        what = (
            f"lands at {x_other!r}, not {x_one!r}"
            if other.outcome == LANDED
            else REASONS[other.outcome]
        )
        found.append(Failure("cut wall", number, x, float(other.end[body.T]), what))
    return found


def is_sure(path: Trajectory) -> bool:
    """Whether rounding moves the end of a path by much less than ALIKE, and not to another bin."""
    if path.outcome != LANDED:
        return False
    certainty = certainty_of(path)
    return certainty.certain and bool(certainty.errors[-1] <= ALIKE / 1000.0)


Found = Iterator[tuple[int, str, float, str]]
"""Number of the drop, kind of failure, time, description."""


def _budgets(board: Board, paths: list[Trajectory]) -> Found:
    bounce = max(board.ball.restitution, board.wall_material.restitution)
    if board.pegs:
        bounce = max(bounce, board.peg_material.restitution)
    for drop, path in enumerate(paths):
        reason = REASONS[path.outcome]
        if path.outcome in {LANDED, BALANCED, WEDGED}:
            continue
        if path.outcome == EVENT_LIMIT and bounce > LIVELY:
            continue
        if path.outcome == TIME_LIMIT and (board.drag > HEAVY_DRAG or bounce > LIVELY):
            continue
        yield drop, reason.split(":")[0], float(path.end[body.T]), reason


def _events(bodies: Bodies, paths: list[Trajectory]) -> Found:
    events = np.concatenate([path.events[:MOST] for path in paths])
    marks = np.concatenate([path.marks[:MOST] for path in paths]).astype(np.intp)
    owner = np.repeat(np.arange(len(paths)), [min(len(path.events), MOST) for path in paths])
    named = marks[:, 0] != KIND_LANDING
    events, marks, owner = events[named], marks[named], owner[named]
    kinds, index = marks.T
    impact = (kinds == KIND_PEG) | (kinds == KIND_WALL)
    is_wall = np.where(impact, kinds == KIND_WALL, index < 0)
    item = np.where(impact | ~is_wall, index, -1 - index)
    item = np.where(is_wall, bodies.pegs + item, item)
    apart = bodies.offsets(events[:, 1:3], item)
    far = np.hypot(apart[:, 0], apart[:, 1])
    gap = far - bodies.reach[item]
    for i in np.flatnonzero(np.abs(gap) > NEAR * bodies.radius).tolist():
        event = "impact" if impact[i] else "contact"
        what = f"{event} is {gap[i]:.3g} m off {bodies.name(int(item[i]))}"
        yield int(owner[i]), f"{event} off its body", float(events[i, 0]), what
    speed = (events[:, 3:5] * apart).sum(axis=1) / np.maximum(far, 1e-300)
    for i in np.flatnonzero(impact & (speed < -INWARDS)).tolist():
        what = f"{speed[i]:.3g} m/s off {bodies.name(int(item[i]))} after an impact on it"
        yield int(owner[i]), "hits inwards", float(events[i, 0]), what
    yield from _depths(bodies, events[:, 1:3], events[:, 0], owner)


def _depths(bodies: Bodies, points: Floats, times: Floats, owner: Ints) -> Found:
    if not len(points) or not len(bodies.reach):
        return
    for first in range(0, len(points), 1 << 16):
        gaps = bodies.gaps(points[first : first + (1 << 16)])
        lowest = gaps.argmin(axis=1)
        depth = -gaps[np.arange(len(gaps)), lowest]
        for i in np.flatnonzero(depth > NEAR * bodies.radius).tolist():
            what = f"{depth[i]:.3g} m deep in {bodies.name(int(lowest[i]))}"
            yield int(owner[first + i]), "depth", float(times[first + i]), what


def _places(bodies: Bodies, sampled: _Sampled) -> Found:
    points, times = sampled.states[:, body.X : body.Y + 1], sampled.states[:, body.T]
    yield from _depths(bodies, points, times, sampled.owner)
    rows = np.flatnonzero(sampled.rides)
    for some in np.array_split(rows, 1 + len(rows) // (1 << 16)):
        nearest = bodies.gaps(points[some]).min(axis=1, initial=np.inf)
        for i in np.flatnonzero(nearest > NEAR * bodies.radius).tolist():
            what = f"rides {nearest[i]:.3g} m off any body"
            row = some[i]
            yield int(sampled.owner[row]), "rides on nothing", float(times[row]), what


def _jumps(bodies: Bodies, sampled: _Sampled) -> Found:
    before, after = sampled.states[sampled.before], sampled.states[sampled.before + 1]
    way = np.hypot(*(after - before)[:, body.X : body.Y + 1].T)
    for i in np.flatnonzero(way > NEAR * bodies.radius).tolist():
        what = f"jumps by {way[i]:.3g} m"
        yield int(sampled.owner[sampled.before[i]]), "jump", float(after[i, body.T]), what


def _energies(board: Board, paths: list[Trajectory], sampled: _Sampled) -> Found:
    states = sampled.states
    speed = states[:, body.VX] ** 2 + states[:, body.VY] ** 2
    spin = (board.ball.radius * states[:, body.OMEGA]) ** 2
    # A disc's moment of inertia is m R^2 / 2.
    energy = 0.5 * speed + 0.25 * spin - board.gravity * states[:, body.Y]
    scale = board.gravity * (board.bins.y - board.drop.y)
    first = np.searchsorted(sampled.owner, np.arange(len(paths) + 1))
    for drop in range(len(paths)):
        rows = slice(first[drop], first[drop + 1])
        mine = energy[rows]
        gain = mine[1:] - np.minimum.accumulate(mine)[:-1]
        for i in np.flatnonzero(gain > GAIN * scale)[:1].tolist():
            what = f"gains {gain[i] / scale:.3g} of the energy of a fall"
            yield drop, "energy", float(states[rows][i + 1, body.T]), what


def _rests(bodies: Bodies, paths: list[Trajectory]) -> Found:
    for drop, path in enumerate(paths):
        if path.outcome not in {BALANCED, WEDGED}:
            continue
        place = path.end[None, body.X : body.Y + 1]
        touched = np.flatnonzero(np.abs(bodies.gaps(place)[0]) <= NEAR * bodies.radius)
        normals = bodies.offsets(np.repeat(place, len(touched), axis=0), touched)
        normals /= bodies.reach[touched, None]
        below = (np.abs(normals[:, 0]) < NEAR) & (normals[:, 1] < 0.0)
        turn = normals[:, None, 0] * normals[None, :, 1] - normals[:, None, 1] * normals[None, :, 0]
        if not below.any() and not (np.abs(turn) > NEAR).any():
            what = f"lies still on {[bodies.name(i) for i in touched.tolist()]}"
            yield drop, "rests on nothing", float(path.end[body.T]), what
