"""A ball that rolls or slides, as Taylor series in time whose remainders are proven.

The laws are those of `engine/physics/contact.py`; their right-hand sides are polynomials, so the
coefficients x_i of the motion follow from each other. With time in units of H, those of the first
N terms show |x_i| <= X / (i + 1)^2, and the recursion carries that bound on to all later ones:

    sum over j of |u_j n_(i-j)| <= U A sum 1 / ((j + 1)^2 (i - j + 1)^2) <= C U A / (i + 1)^2

with C = 4 zeta(2), of which x_(i+1) is kappa H / (i + 1) times. Once kappa H C U (N + 1)^2 / N^3
is at most 1 (and the like for the speed) this is again below A / (i + 2)^2. So what is left out
after N terms is at most X rho^N / ((N + 1)^2 (1 - rho)) up to the time rho H < H.
"""

from dataclasses import dataclass
from operator import mul
from typing import NamedTuple

from flint import arb, arb_poly, ctx

from engine.certified.balls import ONE, ZERO
from engine.certified.scene import Scene
from engine.certified.surfaces import Surface, unit_vector

ROLLING = 0
SLIDING = 1
FRICTIONLESS = 2

LONGEST_STEP = 2.0
"""s. On a wall the series converge for ever; longer steps would pass over too many surfaces."""

_CONVOLUTION = 6.58  # 4 zeta(2), rounded up
_TERMS_PER_BIT = 0.4
"""More make longer steps, and cost their square: flat around this."""
_LEAST_TERMS = 24
_SLACK = 1.001  # what float64 may round off of a bound, a million times over


@dataclass(frozen=True, slots=True)
class Contact:
    """A ball on a surface: contact normal, speed u along (-n_y, n_x), spin, and how it moves.

    slip_sign: of u - omega R while it slides.
    """

    t: arb
    x: arb
    y: arb
    nx: arb
    ny: arb
    u: arb
    omega: arb
    mode: int
    slip_sign: int


class Series(NamedTuple):
    """A function of time on a stretch: a polynomial in s / H, and how far it may be off."""

    terms: list[arb]
    tail: arb

    def at(self, share: arb) -> arb:
        """Its value at the time share H."""
        return arb_poly(self.terms)(share) + arb(0, self.tail)


def linear(start: arb, *parts: tuple[arb, Series]) -> Series:
    """start + the sum of factor times series."""
    count = max(len(series.terms) for _, series in parts)
    terms = [ZERO] * count
    terms[0] = start
    tail = ZERO
    for factor, series in parts:
        for i, term in enumerate(series.terms):
            terms[i] = terms[i] + factor * term
        tail = tail + (abs(factor) * series.tail).upper()
    return Series(terms, tail.upper())


def square(series: Series, end: float) -> Series:
    """The series squared, with what the tail does to it up to `end`."""
    poly = arb_poly(series.terms)
    size = arb_poly([abs(term).upper() for term in series.terms])(arb(end))
    tail = series.tail * (2 * size + series.tail)
    return Series(list((poly * poly).coeffs()) or [ZERO], tail.upper())


class Stretch:
    """The motion from `start` on, for `unit` times `end` seconds."""

    def __init__(self, scene: Scene, surface: Surface, start: Contact) -> None:
        self.scene, self.surface, self.start = scene, surface, start
        self.kappa = surface.curvature
        terms = max(_LEAST_TERMS, int(_TERMS_PER_BIT * ctx.prec))
        lists = self._expand(terms)
        self.end = 2.0 ** (-ctx.prec / terms)
        self.unit = _convergence(lists, LONGEST_STEP / self.end)
        self._scale(lists)

    def _expand(self, terms: int) -> list[list[arb]]:
        """The first coefficients of n_x, n_y, u and omega, time in seconds."""
        start, scene = self.start, self.scene
        g, k, kappa = scene.gravity, scene.drag, self.kappa
        curved = not kappa.is_zero()
        share = ONE / 3 * 2 if start.mode == ROLLING else ONE
        grip = start.slip_sign * self.surface.pair.friction
        nx, ny, u, omega = [start.nx], [start.ny], [start.u], [start.omega]
        for i in range(terms - 1):
            if curved:
                back = u[::-1]
                nx_next = -kappa * sum(map(mul, ny, back), ZERO) / (i + 1)
                ny_next = kappa * sum(map(mul, nx, back), ZERO) / (i + 1)
            else:
                nx_next = ny_next = ZERO
            drive = g * nx[i] - k * u[i]
            if start.mode == SLIDING:
                force = -g * ny[i]
                if curved:
                    force = force - kappa * sum(map(mul, u, back), ZERO)
                u.append((drive - grip * force) / (i + 1))
                omega.append(2 * grip * force / scene.radius / (i + 1))
            else:
                u.append(share * drive / (i + 1))
            nx.append(nx_next)
            ny.append(ny_next)
        return [nx, ny, u, omega]

    def _scale(self, lists: list[list[arb]]) -> None:
        """Take the time in units, shorter ones until the bounds hold; then make the series."""
        terms = len(lists[0])
        while True:
            unit = arb(self.unit)
            powers = [ONE]
            for _ in range(terms - 1):
                powers.append(powers[-1] * unit)
            nx, ny, u, omega = (list(map(mul, values, powers)) for values in lists)
            normal, speed = max(_bound(nx), _bound(ny)), _bound(u)
            bounds = self._proven_bounds(terms, normal, speed)
            if bounds is not None:
                break
            self.unit *= 0.5
        normal, speed, push = bounds
        rest = arb(self.end) ** terms / (1 - arb(self.end)) / (terms + 1) ** 2
        self.nx, self.ny = Series(nx, (rest * normal).upper()), Series(ny, (rest * normal).upper())
        self.u = Series(u, (rest * speed).upper())
        way = [ZERO, *(unit * value / (i + 1) for i, value in enumerate(u))]
        self.way = Series(way, (unit * self.u.tail).upper())
        if self.start.mode == SLIDING:
            turn = 2 * self.surface.pair.friction * unit / self.scene.radius
            self.omega = Series(omega, (turn * push * rest).upper())
        elif self.start.mode == ROLLING:
            self.omega = linear(ZERO, (1 / self.scene.radius, self.u))
        else:
            self.omega = Series(omega, ZERO)
        self.force = linear(ZERO, (-self.scene.gravity, self.ny))
        if not self.kappa.is_zero():
            bent = square(self.u, self.end)
            self.force = linear(ZERO, (-self.scene.gravity, self.ny), (-self.kappa, bent))

    def _proven_bounds(
        self, terms: int, normal: float, speed: float
    ) -> tuple[float, float, float] | None:
        """A, U and a bound of N's coefficients that the recursion carries on, or None."""
        scene, h = self.scene, self.unit
        g, k, kappa = float(scene.gravity), float(scene.drag), float(self.kappa) * _SLACK
        later = (terms + 1) ** 2 / terms**3 * _SLACK
        friction = float(self.surface.pair.friction) if self.start.mode == SLIDING else 0.0
        speed = max(speed, 4.0 * h * g * normal * (1.0 + friction) * later)
        push = (g * normal + kappa * _CONVOLUTION * speed * speed) * _SLACK
        if kappa * h * _CONVOLUTION * speed * later > 1.0:
            return None
        if h * (g * normal + k * speed + friction * push) * later > speed:
            return None
        return normal, speed, push

    def at(self, share: arb) -> Contact:
        """The ball at the time share H; its normal has length one, and is put there again."""
        start, surface = self.start, self.surface
        if self.kappa.is_zero():
            nx, ny = start.nx, start.ny
            way = self.way.at(share)
            x, y = start.x - ny * way, start.y + nx * way
        else:
            nx, ny = unit_vector(self.nx.at(share), self.ny.at(share))
            x, y = surface.at_contact(start.x, start.y, nx, ny)
        t = start.t + share * arb(self.unit)
        u, omega = self.u.at(share), self.omega.at(share)
        return Contact(t, x, y, nx, ny, u, omega, start.mode, start.slip_sign)


def _bound(values: list[arb]) -> float:
    """The smallest X for which |x_i| <= X / (i + 1)^2 in all of `values`, rounded up."""
    sizes = (float(abs(value).upper()) * (i + 1) ** 2 for i, value in enumerate(values))
    return max(sizes) * _SLACK


def _convergence(lists: list[list[arb]], longest: float) -> float:
    """About the radius of convergence in s, a tenth less; `longest` at most."""
    fastest = 0.1 / longest
    for values in lists[:3]:
        for i in (len(values) - 2, len(values) - 1):
            size = abs(values[i]).upper()
            if size > 0:
                fastest = max(fastest, float((size.log() / i).exp()))
    return min(longest, 0.9 / fastest)
