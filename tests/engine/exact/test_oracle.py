"""The oracle is checked against itself and against formulas, before other tests rely on it."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import mpmath
import pytest

from benchmarks.scenes.contact_scenes import trial
from plinko.engine.board.parts import Peg, Wall
from plinko.engine.constants import (
    KIND_CONTACT_BEGIN,
    KIND_CONTACT_CHANGE,
    KIND_CONTACT_END,
    KIND_PEG,
)
from tools.oracle import Event, OracleDrop, OracleError, oracle_drop
from tools.oracle.scenes import scene

mp = mpmath.MPContext()
mp.dps = 70
G = mp.mpf(9.81)
DIGITS = mp.mpf(10) ** -45  # tolerance at fifty digits


def energy(event: Event, *, spin: Any = 0) -> Any:
    """Mechanical energy per mass in J/kg; if `spin` is R, with the rotation of a disc."""
    kinetic = (event.vx**2 + event.vy**2) / 2 + (spin * event.omega) ** 2 / 4
    return kinetic - G * event.y


def of_kind(drop: OracleDrop, kind: int) -> list[Event]:
    return [e for e in drop.events if e.kind == kind]


def test_a_ball_in_the_open_falls_a_parabola() -> None:
    drop = oracle_drop(scene(), 0.25)
    assert abs(drop.duration - mp.sqrt(2 * 3 / G)) < DIGITS
    assert (drop.bin, drop.x_end) == (1, mp.mpf(0.25))


@pytest.mark.parametrize("k", [0.01, 0.3, 2.0, 5.0])
def test_a_ball_in_the_open_falls_through_air_by_the_closed_form(k: float) -> None:
    drop = oracle_drop(scene(drag=k), 0.25)
    drag, t = mp.mpf(k), drop.duration
    fallen = (G / drag) * t - (G / drag**2) * (1 - mp.exp(-drag * t))
    assert abs(fallen - 3) < DIGITS
    assert abs(drop.events[-1].vy - (G / drag) * (1 - mp.exp(-drag * t))) < DIGITS


def test_a_hit_on_a_peg_is_where_geometry_says() -> None:
    """The ball falls off-centre on a peg: it hits at y = -sqrt(D^2 - x^2) and is mirrored (e =
    1)."""
    drop = oracle_drop(scene(pegs=(Peg(0.0, 0.0, 0.05),), restitution=1.0), 0.08)
    hit, reach = drop.events[0], mp.mpf(0.05) + mp.mpf(0.1)
    x = mp.mpf(0.08)
    assert hit.kind == KIND_PEG
    assert abs(hit.y + mp.sqrt(reach**2 - x**2)) < DIGITS
    assert abs(hit.t - mp.sqrt(2 * (1 + hit.y) / G)) < DIGITS
    down, nx, ny = G * hit.t, x / reach, hit.y / reach
    assert abs(hit.vx + 2 * down * ny * nx) < DIGITS
    assert abs(hit.vy - (down - 2 * down * ny * ny)) < DIGITS


def test_friction_turns_slip_into_spin_up_to_coulombs_bound() -> None:
    """On a sloping wall, low friction gives the impulse mu j, and high friction ends in rolling."""
    wall = (Wall(-1.0, -0.5, 1.0, 0.5),)
    for mu, sticks in ((0.1, False), (0.9, True)):
        board = scene(walls=wall, friction=mu, restitution=0.5)
        hit = oracle_drop(board, 0.0).events[0]
        normal, tangent = 2 / mp.sqrt(5), 1 / mp.sqrt(5)
        into, slip = G * hit.t * normal, G * hit.t * tangent
        along = hit.vx * normal + hit.vy * tangent
        lost = slip / 3 if sticks else mp.mpf(board.ball.friction) * mp.mpf("1.5") * into
        assert abs(along - (slip - lost)) < DIGITS
        assert abs(hit.omega - 2 * lost / mp.mpf(0.1)) < DIGITS
        assert (abs(along - hit.omega * mp.mpf(0.1)) < DIGITS) is sticks


def test_without_loss_energy_is_kept_to_all_digits() -> None:
    drop = oracle_drop(trial(12, 1.0, 0.0, 0.0), 0.123, dps=100)
    start = mp.zero  # at rest at y = 0
    assert len(drop.events) > 30
    assert max(abs(energy(e) - start) for e in drop.events) < mp.mpf(10) ** -60


def test_friction_bounces_and_air_only_take_energy() -> None:
    drop = oracle_drop(trial(12, 0.5, 0.2, 2.0), -0.379)
    radius = mp.mpf(trial(12, 0.5, 0.2, 2.0).ball.radius)
    levels = [energy(e, spin=radius) for e in drop.events]
    assert {KIND_PEG, KIND_CONTACT_BEGIN, KIND_CONTACT_CHANGE} < {e.kind for e in drop.events}
    assert all(later < earlier + DIGITS for earlier, later in pairwise(levels))


def test_a_frictionless_slider_leaves_a_peg_where_energy_says() -> None:
    """g D cos(theta) = u^2 with u^2 = u0^2 + 2 g D (cos theta0 - cos theta)."""
    drop = oracle_drop(scene(pegs=(Peg(0.0, 0.0, 0.4),)), 0.001)
    begin, end = of_kind(drop, KIND_CONTACT_BEGIN)[0], of_kind(drop, KIND_CONTACT_END)[0]
    reach = mp.mpf(0.4) + mp.mpf(0.1)
    speed = begin.vx**2 + begin.vy**2
    predicted = (2 * -begin.y / reach + speed / (G * reach)) / 3
    assert abs(-end.y / reach - predicted) < DIGITS
    assert abs(energy(end) - energy(begin)) < DIGITS


def test_a_slider_with_friction_obeys_the_law_of_speed_squared() -> None:
    """d(u^2)/da = 2 g D (cos a + mu sin a) + 2 mu u^2, a the angle from +x: closed form."""
    drop = oracle_drop(scene(pegs=(Peg(0.0, 0.0, 0.4),), friction=0.05), 0.2)
    begin = of_kind(drop, KIND_CONTACT_BEGIN)[0]
    end = of_kind(drop, KIND_CONTACT_END)[0]
    assert not of_kind(drop, KIND_CONTACT_CHANGE)
    assert begin.vx > mp.mpf(0.1) * begin.omega > 0
    reach, mu = mp.mpf(0.4) + mp.mpf(0.1), mp.mpf(0.05)
    # Particular solution A cos a + B sin a; compare the coefficients of cosine and sine.
    force = 2 * G * reach
    b = force * (1 - 2 * mu * mu) / (1 + 4 * mu * mu)
    a = -3 * mu * force / (1 + 4 * mu * mu)

    def rest(e: Event) -> Any:
        angle = mp.atan2(e.y, e.x)
        own = e.vx**2 + e.vy**2 - a * mp.cos(angle) - b * mp.sin(angle)
        return own * mp.exp(-2 * mu * angle)

    assert abs(rest(end) - rest(begin)) < DIGITS


Law = Callable[[list[Any]], list[Any]]


def midpoint(law: Law, y: list[Any], span: Any, parts: int) -> list[Any]:
    """Integrate `span` in `parts` steps of the midpoint rule, whose error is even in the step."""
    h = span / parts
    before, now = y, [a + h * b for a, b in zip(y, law(y), strict=True)]
    for _ in range(parts - 1):
        slope = law(now)
        before, now = now, [a + 2 * h * b for a, b in zip(before, slope, strict=True)]
    return now


def integrated(law: Law, y: list[Any], span: Any, steps: int = 8, columns: int = 16) -> list[Any]:
    """Gragg's extrapolation with `columns` columns (Hairer, Norsett and Wanner I, II.9)."""
    for _ in range(steps):
        table: list[list[list[Any]]] = []
        for row in range(columns):
            table.append([midpoint(law, y, span / steps, 2 * row + 2)])
            for col in range(1, row + 1):
                ratio = (mp.mpf(row + 1) / (row + 1 - col)) ** 2 - 1
                left, above = table[row][col - 1], table[row - 1][col - 1]
                better = [p + (p - q) / ratio for p, q in zip(left, above, strict=True)]
                table[row].append(better)
        y = table[-1][-1]
    return y


@pytest.mark.parametrize("drag", [0.0, 2.0])
def test_rolling_and_sliding_agree_with_a_general_integrator(drag: float) -> None:
    """Integrate over the angle from one contact event to the next."""
    friction = 0.4
    drop = oracle_drop(scene(pegs=(Peg(0.0, 0.0, 0.4),), friction=friction, drag=drag), 0.01)
    phases = [e for e in drop.events if e.kind in (2, 3, 4)]
    assert [e.kind for e in phases] == [KIND_CONTACT_BEGIN, KIND_CONTACT_CHANGE, KIND_CONTACT_END]
    reach, size = mp.mpf(0.4) + mp.mpf(0.1), mp.mpf(0.1)
    mu, k = mp.mpf(friction), mp.mpf(drag)
    mu = mp.sqrt(mu * mu)

    def rolls(y: list[Any]) -> list[Any]:
        return [y[1] / reach, (G * mp.cos(y[0]) - k * y[1]) * 2 / 3, mp.zero]

    def slides(y: list[Any]) -> list[Any]:
        push = -G * mp.sin(y[0]) - y[1] ** 2 / reach
        return [y[1] / reach, G * mp.cos(y[0]) - k * y[1] - mu * push, 2 * mu * push / size]

    for law, (a, b) in zip((rolls, slides), pairwise(phases), strict=True):
        u = mp.hypot(a.vx, a.vy)
        angle, speed, omega = integrated(law, [mp.atan2(a.y, a.x), u, a.omega], b.t - a.t)
        assert abs(mp.cos(angle) * reach - b.x) < 1e-26
        assert abs(speed - mp.hypot(b.vx, b.vy)) < 1e-26
        spin = speed / size if law is rolls else omega
        assert abs(spin - b.omega) < 1e-24


def test_a_disc_rolls_down_a_wall_by_two_thirds_of_the_slope() -> None:
    """With drag, u' = 2/3 (g sin a - k u); compare the time at the wall's end."""
    for drag in (0.0, 1.5):
        wall = Wall(-1.0, -0.25, 1.0, 0.25)
        board = scene(walls=(wall,), friction=0.9, drag=drag)
        drop = oracle_drop(board, -0.5)
        begin, end = of_kind(drop, KIND_CONTACT_BEGIN)[0], of_kind(drop, KIND_CONTACT_END)[0]
        slope = mp.mpf("0.25") / mp.sqrt(1 + mp.mpf("0.0625"))
        u0, u1 = (mp.hypot(e.vx, e.vy) for e in (begin, end))
        corner_x = mp.mpf(1) + slope * mp.mpf(0.1)
        length = (corner_x - begin.x) / mp.sqrt(1 - slope**2)
        t, a, c = end.t - begin.t, G * slope * 2 / 3, mp.mpf(drag) * 2 / 3
        if drag:
            speed = a / c + (u0 - a / c) * mp.exp(-c * t)
            path = a / c * t + (u0 - a / c) * (1 - mp.exp(-c * t)) / c
        else:
            speed, path = u0 + a * t, u0 * t + a * t * t / 2
        assert u1**2 > G * mp.mpf(0.1)  # too fast to follow the end's curve: it leaves at once
        assert abs(path - length) < DIGITS
        assert abs(speed - u1) < DIGITS


def test_cutting_dying_bounces_moves_a_slider_by_little() -> None:
    peg = (Peg(0.0, 0.0, 0.4),)
    for friction, apart in ((0.9, 1e-17), (0.02, 1e-8)):
        board = scene(pegs=peg, friction=friction, restitution=0.5)
        ends = [
            of_kind(oracle_drop(board, 0.02, cut=cut), KIND_CONTACT_END)[0] for cut in (1e-8, 1e-20)
        ]
        assert 0 < abs(ends[0].x - ends[1].x) < apart


def test_the_path_is_whole_from_event_to_event() -> None:
    drop = oracle_drop(trial(12, 0.5, 0.2, 2.0), -0.379)
    before = mp.mpf(10) ** -20
    for event in drop.events:
        x, y = drop.position_at(event.t - before)
        assert mp.hypot(x - event.x, y - event.y) < 1e-18
        assert mp.hypot(drop.position_at(event.t)[0] - event.x, 0) < DIGITS
    with pytest.raises(ValueError, match="outside"):
        drop.position_at(-1.0)


def test_a_cut_below_the_rounding_is_refused() -> None:
    with pytest.raises(OracleError, match="cut"):
        oracle_drop(scene(), 0.0, cut=1e-60)
