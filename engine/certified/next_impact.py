"""Proves which surface a flight hits first, and when, by excluding all others until then."""

from typing import NamedTuple

from flint import arb

from plinko.engine.certified.balls import ZERO, Proof, UndecidedError, upper
from plinko.engine.certified.first_root import first_root
from plinko.engine.certified.flight import (
    CircleDistance,
    Flight,
    LineDistance,
    LineRebound,
    ReboundDistance,
)
from plinko.engine.certified.reach import NEVER, rebound_reach
from plinko.engine.certified.scene import Scene
from plinko.engine.certified.surfaces import Circle, Face, Surface

# How the ball left a surface that it touches at the start of a flight: the order of the root that
# the distance to the surface has there.
BOUNCED = 1
LIFTED = 2  # with no speed off the surface, and no force onto it
ROLLED_OFF = 3  # with neither speed nor force: the normal force has just become zero
PAST = 0  # not an order: the ball has passed the surface and cannot hit it again


class Touch(NamedTuple):
    """How the ball left a surface, and its speed off it in m/s."""

    how: int
    off: arb


TIGHT = 1e-12
"""m, m/s and m/s^2. An enclosure that is at most this wide can stand for a float64 number."""

Touched = dict[Surface, Touch]
"""The surfaces that the ball touches when a flight starts."""


class Hit(NamedTuple):
    """The end of a flight: its time and the surfaces hit; without any, it is the bins' line.

    There are several surfaces if symmetry makes their times equal. They are in order of rank, in
    which the impacts are applied.
    """

    time: arb
    surfaces: tuple[Surface, ...]
    approach: arb | None  # v.n at the first surface, if known more sharply than from v and n


class _Root(NamedTuple):
    time: arb
    surface: Surface | None  # None: the bins' line
    approach: arb | None = None


def next_impact(scene: Scene, flight: Flight, touched: Touched, proof: Proof) -> Hit | None:
    """The first impact of `flight`, at whose start the ball touches the surfaces `touched`.

    None if the ball leaves the board for good.

    Window by window: the screen names the surfaces that the ball may touch, each with a time before
    which it does not. They are searched in order of these times, until the earliest root found is
    proven to be before all times that are left.
    """
    start = 0.0
    left = next(iter(touched)) if len(touched) == 1 else None
    # A ball that slides along a face passes circles that are flush with it tangentially. The
    # distance to an end has a double root there, which no precision would decide, and which is not
    # an impact.
    faces = slid_along(flight, touched)
    while True:
        reaches = scene.screen.reaches(flight.course, start, left)
        roots = _again(flight, touched, reaches.end, proof) if start == 0.0 else []
        soonest = min((upper(root.time) for root in roots), default=reaches.end)
        for time, surface in reaches.found:
            if time > soonest:
                break
            if surface is None:
                line = LineDistance.to_bins(flight, scene.bins_y)
                root = first_root(line, time, reaches.end, proof, "the bins' line")
            elif not _is_grazed(scene, surface, faces) and _is_asked(surface, touched, start):
                twin = _continued(surface, touched) if start == 0.0 else None
                if twin is not None and isinstance(surface, Face):
                    root = _along(flight, surface, touched[twin], reaches.end, proof)
                else:
                    root = _entry(flight, surface, time, reaches.end, proof)
            else:
                continue
            if root is not None:
                roots.append(_Root(root, surface))
                soonest = min(soonest, upper(root))
        if roots:
            return _first(flight, roots, proof)
        if reaches.end == NEVER:
            return None
        start = reaches.end


def slid_along(flight: Flight, touched: Touched) -> list[Face]:
    """Faces that the ball touches throughout its flight: it has neither speed nor acceleration off
    them."""
    return [
        surface
        for surface, touch in touched.items()
        if touch.how == LIFTED
        and isinstance(surface, Face)
        and (flight.ax * surface.nx + flight.ay * surface.ny).is_zero()
    ]


def _is_grazed(scene: Scene, surface: Surface, faces: list[Face]) -> bool:
    """Whether a ball that slides along these faces passes the surface without an impact."""
    return isinstance(surface, Circle) and any(scene.are_flush(face, surface) for face in faces)


def _is_asked(surface: Surface, touched: Touched, start: float) -> bool:
    """Whether to search for a surface in the usual way, not as one that the ball has just left.

    A face that the ball left without a speed is never searched: its distance never falls.
    """
    if surface not in touched:
        return True
    return start > 0.0 and (touched[surface].how == BOUNCED or isinstance(surface, Circle))


def _continued(surface: Surface, touched: Touched) -> Face | None:
    """A touched face that lies exactly on the line of this one, if it is a face."""
    for other in touched:
        if isinstance(surface, Face) and isinstance(other, Face) and _are_level(surface, other):
            return other
    return None


def _are_level(a: Face, b: Face) -> bool:
    apart = (b.x - a.x) * a.nx + (b.y - a.y) * a.ny
    return (a.nx - b.nx).is_zero() and (a.ny - b.ny).is_zero() and apart.is_zero()


def _along(flight: Flight, face: Face, touch: Touch, end: float, proof: Proof) -> arb | None:
    """When the ball hits a face that lies on the line of one that it touches, or None.

    Without a speed off that line it does not come back to it from its front.
    """
    if touch.how != BOUNCED:
        return None
    root = _rebound(flight, face, touch.off, end, proof)
    return None if root is None else root.time


def _again(flight: Flight, touched: Touched, end: float, proof: Proof) -> list[_Root]:
    """The times at which the ball hits again the surfaces that it touches at the start."""
    roots = []
    for surface, touch in touched.items():
        if touch.how == BOUNCED:
            root = _rebound(flight, surface, touch.off, end, proof)
            if root is not None:
                roots.append(root)
        elif touch.how == PAST:
            continue
        elif isinstance(surface, Circle):
            time = _circle_again(flight, surface, touch.how, end, proof)
            if time is not None:
                roots.append(_Root(time, surface))
        else:
            # With no speed off a face and no pull onto it, its distance never falls.
            pull = flight.ax * surface.nx + flight.ay * surface.ny
            proof.require(bool(pull >= 0), f"whether the ball lifts off {surface.name}")
    return roots


def _rebound(flight: Flight, surface: Surface, off: arb, end: float, proof: Proof) -> _Root | None:
    """When the ball hits again a surface that it bounced off.

    The distance has a root at the start, so the search is for a root of distance over time.
    """
    if isinstance(surface, Circle):
        start = _circle_rebound_reach(flight, surface, off, end)
        if start == NEVER:
            return None
        again = ReboundDistance(flight, surface, off, end)
        time = first_root(again, start, end, proof, surface.name)
        return None if time is None else _Root(time, surface, again.approach(time))
    pull = flight.ax * surface.nx + flight.ay * surface.ny
    from_line = LineRebound(LineDistance(flight, ZERO, off, pull))
    time = first_root(from_line, 0.0, end, proof, surface.name)
    time = _on_face(flight, surface, time, proof)
    return None if time is None else _Root(time, surface, from_line.approach(time))


def _circle_rebound_reach(flight: Flight, circle: Circle, off: arb, end: float) -> float:
    """A time until which the ball does not hit again the circle that it bounced off, or NEVER.

    It is the root of a parabola in double precision below f(s) / s = 2 D off + (|v|^2 + q.a) s + …
    Each coefficient is lowered by a millionth of its terms, far more than rounding. Returns 0,
    which excludes nothing, if the flight's enclosure is too wide for float64.
    """
    x, y, vx, vy, ax, ay = flight.course.state.tolist()
    speed = float(off)
    if float(off.rad()) > 1e-9 * speed or flight.course.errors.max() > TIGHT:
        return 0.0
    qx, qy, k = x - float(circle.x), y - float(circle.y), flight.course.drag
    vv, va, aa = vx * vx + vy * vy, vx * ax + vy * ay, ax * ax + ay * ay
    qa, parts = qx * ax + qy * ay, abs(qx * ax) + abs(qy * ay)
    third = 6.0 * min(va, 0.0) - 1e-6 * (abs(vx * ax) + abs(vy * ay))
    third -= 2.0 * k * max(qa + 0.5 * aa * end * end + max(va, 0.0) * end + 1e-6 * parts, 0.0)
    first = 2.0 * float(circle.reach) * speed * (1.0 - 1e-6)
    return rebound_reach(first, vv + qa - 1e-6 * (vv + parts), third / 3.0, end)


def _circle_again(
    flight: Flight, circle: Circle, order: int, end: float, proof: Proof
) -> arb | None:
    """When the ball hits again a circle that it left without a speed.

    f has a root of this order at the start; f(s) / s^order is positive there and for a while. The
    search starts at a time until which a bound of the next derivative proves that.
    """
    name = circle.name
    distance = CircleDistance(flight, circle, end)
    if order == LIFTED:
        # f >= s^2 / 2 (f'' + min f''' s / 3)
        lead = flight.vv + distance.qa
        least = distance.low3 / 3
        proof.require(bool(lead > 0), f"whether the ball lifts off {name}")
        lead = 2 * lead
    else:
        # f >= s^3 / 6 (f''' + min f'''' s / 4), with q.a = -|v|^2 where the normal force vanishes
        lead = 6 * flight.va + 2 * flight.k * flight.vv
        least = _least_fourth(flight, circle, end) / 4
        proof.require(bool(lead > 0), f"whether the ball leaves {name}")
    if lead + least * arb(end) > 0:
        return None
    free = min(end, 0.5 * float((-lead / least).lower()))
    proof.require(bool(lead + least * arb(free) > 0), f"whether the ball leaves {name}")
    return first_root(distance, free, end, proof, name)


def _least_fourth(flight: Flight, circle: Circle, end: float) -> arb:
    """Lower bound of f'''' = 6 a.a - 8 k v.a + 2 k^2 q.a until `end`, for a ball that starts on the
    circle."""
    pull, horizon = flight.aa.sqrt(), arb(end)
    speed = flight.vv.sqrt() + pull * horizon
    far = circle.reach + speed * horizon
    return (-8 * flight.k * speed * pull - 2 * flight.k**2 * pull * far).lower()


def _entry(flight: Flight, surface: Surface, start: float, end: float, proof: Proof) -> arb | None:
    """When the ball first enters a surface in (start, end], or None."""
    if isinstance(surface, Circle):
        distance = CircleDistance(flight, surface, end)
        if start == 0.0:
            value, slope, _ = distance.terms(ZERO)
            if surface.is_touched(flight.start.x, flight.start.y, value):
                return _touched_entry(flight, surface, slope, end, proof)
        return first_root(distance, start, end, proof, surface.name)
    line = LineDistance.of_face(flight, surface)
    if start == 0.0 and line.gap.contains(0):
        # The ball touches the infinite line of the face: no contact if its foot is off the wall.
        proof.require(not _may_be_on(flight, surface, ZERO), f"whether {surface.name} is touched")
    root = _line_entry(line, start, end, proof, surface.name)
    return _on_face(flight, surface, root, proof)


def _touched_entry(
    flight: Flight, circle: Circle, slope: arb, end: float, proof: Proof
) -> arb | None:
    """When the ball hits a circle that it touches: at once, or when it comes back."""
    if not proof.is_positive(slope, f"whether the ball moves into {circle.name}"):
        return ZERO
    root = _rebound(flight, circle, slope / (2 * circle.reach), end, proof)
    return None if root is None else root.time


def _line_entry(
    line: LineDistance, start: float, end: float, proof: Proof, what: str
) -> arb | None:
    """When the ball crosses a line from its front. From behind it has to come out first.

    The second derivative keeps its sign, so there is at most one such crossing.
    """
    side = f"which side of {what} the ball is on"
    if proof.is_positive(line.terms(arb(start))[0], side):
        return first_root(line, start, end, proof, what)
    out = first_root(line.turned(), start, end, proof, what)
    if out is None:
        return None
    after = upper(out)
    while not line.terms(arb(after))[0] > 0:
        if not proof.is_positive(line.terms(out)[1], what) or after >= end:
            return None
        after += max(2.0**-52 * after, 2.0 * (after - float(out)))
    return first_root(line, after, end, proof, what) if after < end else None


def _on_face(flight: Flight, face: Face, root: arb | None, proof: Proof) -> arb | None:
    """`root` if the ball's foot is between the wall's ends then, else None."""
    if root is None:
        return None
    at = flight.moment(root)
    along = face.along(at.x, at.y)
    what = f"whether {face.name} or its end is hit"
    inside = proof.is_positive(along, what) and proof.is_positive(face.length - along, what)
    return root if inside else None


def _may_be_on(flight: Flight, face: Face, time: arb) -> bool:
    """Whether the ball's foot may be between the wall's ends; False only with proof."""
    at = flight.moment(time)
    along = face.along(at.x, at.y)
    return not (along < 0 or along > face.length)


def _first(flight: Flight, roots: list[_Root], proof: Proof) -> Hit:
    """The earliest of the roots; those that symmetry makes simultaneous, in order of rank.

    No precision tells two equal times apart. Equality is proven by mirror symmetry only; without
    it, overlapping times are undecided.
    """
    roots.sort(key=lambda root: float(root.time))
    first = roots[0]
    tied = [first]
    for other in roots[1:]:
        proof.count()
        if other.time > first.time:
            continue
        if not _are_mirrored(flight, first.surface, other.surface):
            raise UndecidedError(f"whether {_name(first)} or {_name(other)} is hit first")
        tied.append(other)
    if first.surface is None:
        return Hit(first.time, (), None)
    surfaces = sorted((r.surface for r in tied if r.surface is not None), key=lambda s: s.rank)
    if len(surfaces) > 1:
        proof.ties.append(" and ".join(s.name for s in surfaces) + ", by symmetry")
    return Hit(first.time, tuple(surfaces), first.approach if len(surfaces) == 1 else None)


def _name(root: _Root) -> str:
    return root.surface.name if root.surface is not None else "the bins' line"


def _are_mirrored(flight: Flight, a: Surface | None, b: Surface | None) -> bool:
    """Whether two circles mirror each other in the vertical line along which the ball moves."""
    if not (isinstance(a, Circle) and isinstance(b, Circle)) or not flight.start.vx.is_zero():
        return False
    x = flight.start.x
    off = (a.x - x) + (b.x - x)
    return off.is_zero() and (a.y - b.y).is_zero() and (a.reach - b.reach).is_zero()
