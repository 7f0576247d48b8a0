"""The motion of a ball that rolls or slides, as Taylor series in time with proven remainders.

The laws are those of `engine/physics/contact.py`. Their right-hand sides are polynomials in the
normal n, the speed u and the spin, so each Taylor coefficient follows from those before it.

The remainder after N terms is bounded by induction. With time in units of H, let A and U be such
that |n_i| <= A / (i + 1)^2 and |u_i| <= U / (i + 1)^2 for all i < N. The recursion
n_(i+1) = kappa H / (i + 1) sum over j of u_j n_(i-j) has

    sum over j of |u_j n_(i-j)| <= U A sum 1 / ((j + 1)^2 (i - j + 1)^2) <= C U A / (i + 1)^2

with C = 4 zeta(2). If kappa H C U (N + 1)^2 / N^3 <= 1, then |n_(i+1)| <= A / (i + 2)^2, so the
bound holds for all i; the speed has a similar condition, and H is halved until both hold. Up to the
time rho H < H the remainder is then at most A rho^N / ((N + 1)^2 (1 - rho)), and the same with U.
"""

from dataclasses import dataclass
from operator import mul
from typing import NamedTuple

from flint import arb, arb_poly, ctx

from plinko.engine.certified.balls import ONE, ZERO, Proof
from plinko.engine.certified.scene import Scene
from plinko.engine.certified.surfaces import Surface, unit_vector

ROLLING = 0
SLIDING = 1
FRICTIONLESS = 2

LONGEST_STEP = 2.0
"""s. On a face the series converge everywhere, but a longer step would pass too many surfaces."""

_CONVOLUTION = 6.58  # 4 zeta(2), rounded up
_TERMS_PER_BIT = 0.4
"""More terms make longer steps, but their cost grows as the square; the optimum is flat."""
_LEAST_TERMS = 24
_SLACK = 1.001  # factor on bounds computed in float64, far above their rounding


@dataclass(frozen=True, slots=True)
class Contact:
    """A ball on a surface: contact normal, speed u along (-n_y, n_x), spin and mode of motion.

    slip_sign: the sign of u - omega R while the ball slides.
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
    """A function of time on a stretch: a polynomial in s / H, and a bound of its remainder."""

    terms: list[arb]
    tail: arb

    def at(self, share: arb) -> arb:
        """The value at the time share H."""
        return arb_poly(self.terms)(share) + arb(0, self.tail)


def linear(start: arb, *parts: tuple[arb, Series]) -> Series:
    """The series of `start` plus the sum of factor times series."""
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
    """The square of a series; its tail is a bound up to the time `end`."""
    poly = arb_poly(series.terms)
    size = arb_poly([abs(term).upper() for term in series.terms])(arb(end))
    tail = series.tail * (2 * size + series.tail)
    return Series(list((poly * poly).coeffs()) or [ZERO], tail.upper())


class Stretch:
    """The motion from `start` on, for `unit` times `end` seconds; `unit` is H, `end` is rho."""

    def __init__(self, scene: Scene, surface: Surface, start: Contact, proof: Proof) -> None:
        self.scene, self.surface, self.start = scene, surface, start
        self.law = scene.law_on(surface)
        terms = max(_LEAST_TERMS, int(_TERMS_PER_BIT * ctx.prec))
        lists = self._expand(terms, proof)
        self.end = 2.0 ** (-ctx.prec / terms)
        self.unit = _convergence(lists, LONGEST_STEP / self.end)
        self._scale(lists)

    def _expand(self, terms: int, proof: Proof) -> list[list[arb]]:
        """The first coefficients of n_x, n_y, u and omega, time in seconds."""
        start = self.start
        kappa, g, k, friction, radius = self.law
        curved = not kappa.is_zero()
        share = ONE / 3 * 2 if start.mode == ROLLING else ONE
        grip = start.slip_sign * friction
        nx, ny, u, omega = [start.nx], [start.ny], [start.u], [start.omega]
        for i in range(terms - 1):
            proof.check_time()
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
                omega.append(2 * grip * force / radius / (i + 1))
            else:
                u.append(share * drive / (i + 1))
            nx.append(nx_next)
            ny.append(ny_next)
        return [nx, ny, u, omega]

    def _scale(self, lists: list[list[arb]]) -> None:
        """Scale the coefficients to the unit H, halved until the bounds hold; make the series."""
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
            turn = 2 * self.law.friction * unit / self.law.radius
            self.omega = Series(omega, (turn * push * rest).upper())
        elif self.start.mode == ROLLING:
            self.omega = linear(ZERO, (1 / self.law.radius, self.u))
        else:
            self.omega = Series(omega, ZERO)
        self.force = linear(ZERO, (-self.law.gravity, self.ny))
        if not self.law.curvature.is_zero():
            bent = square(self.u, self.end)
            self.force = linear(ZERO, (-self.law.gravity, self.ny), (-self.law.curvature, bent))

    def _proven_bounds(
        self, terms: int, normal: float, speed: float
    ) -> tuple[float, float, float] | None:
        """A, U and the like bound of the normal force, if the induction step holds; else None.

        U may be larger than the coefficients show: with little speed and much gravity, only a
        larger U satisfies the induction step.
        """
        law, h = self.law, self.unit
        g, k, kappa = float(law.gravity), float(law.drag), float(law.curvature) * _SLACK
        later = (terms + 1) ** 2 / terms**3 * _SLACK
        friction = float(law.friction) if self.start.mode == SLIDING else 0.0
        speed = max(speed, 4.0 * h * g * normal * (1.0 + friction) * later)
        push = (g * normal + kappa * _CONVOLUTION * speed * speed) * _SLACK
        if kappa * h * _CONVOLUTION * speed * later > 1.0:
            return None
        if h * (g * normal + k * speed + friction * push) * later > speed:
            return None
        return normal, speed, push

    def at(self, share: arb) -> Contact:
        """The ball at the time share H. Its normal is made sharper by its length, which is one."""
        start, surface = self.start, self.surface
        if self.law.curvature.is_zero():
            nx, ny = start.nx, start.ny
            way, u, omega = self._on_face(share)
            x, y = start.x - ny * way, start.y + nx * way
        else:
            nx, ny = unit_vector(self.nx.at(share), self.ny.at(share))
            x, y = surface.at_contact(start.x, start.y, nx, ny)
            u, omega = self.u.at(share), self.omega.at(share)
        t = start.t + share * arb(self.unit)
        return Contact(t, x, y, nx, ny, u, omega, start.mode, start.slip_sign)

    def _on_face(self, share: arb) -> tuple[arb, arb, arb]:
        """Way, speed and spin on a face at the time share H, whose accuracy strong drag improves.

        There u' = a - b u with constant a and b. The series multiplies the width of an enclosure of
        u by e^(b s), because the signs of its terms alternate; the solution u_0 e^(-b s) + ...
        divides it by as much. Its own subtractions cancel for small b s, where the series serves.
        """
        start, law = self.start, self.law
        rolls = start.mode == ROLLING
        b = (ONE / 3 * 2 if rolls else ONE) * law.drag
        s = share * arb(self.unit)
        if not b * s > 1:
            return self.way.at(share), self.u.at(share), self.omega.at(share)
        grip = start.slip_sign * law.friction if start.mode == SLIDING else ZERO
        push = -law.gravity * start.ny * grip
        a = (ONE / 3 * 2 if rolls else ONE) * law.gravity * start.nx - push
        decay = (-b * s).exp()
        phi = (1 - decay) / b
        u = start.u * decay + a * phi
        way = start.u * phi + a * (s - phi) / b
        omega = u / law.radius if rolls else start.omega + 2 * push / law.radius * s
        return way, u, omega


def _bound(values: list[arb]) -> float:
    """The smallest X for which |x_i| <= X / (i + 1)^2 in all of `values`, rounded up."""
    sizes = (float(abs(value).upper()) * (i + 1) ** 2 for i, value in enumerate(values))
    return max(sizes) * _SLACK


def _convergence(lists: list[list[arb]], longest: float) -> float:
    """An estimate of the radius of convergence in s, less a tenth, and at most `longest`.

    By the root test on the last two coefficients. It proves nothing: `_proven_bounds` does.
    """
    fastest = 0.1 / longest
    for values in lists[:3]:
        for i in (len(values) - 2, len(values) - 1):
            size = abs(values[i]).upper()
            if size > 0:
                fastest = max(fastest, float((size.log() / i).exp()))
    return min(longest, 0.9 / fastest)
