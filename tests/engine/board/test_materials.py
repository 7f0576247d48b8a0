"""Materials combine as users of Box2D expect, and the reference tables are complete."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.engine.board.materials import GRAVITY, REFERENCE_DENSITY, RESTITUTION, Material, combine
from plinko.engine.constants import EARTH_GRAVITY

SURFACES = st.builds(Material, st.floats(0.0, 1.0), st.floats(0.0, 10.0))


def test_the_bouncier_surface_decides_and_friction_is_averaged() -> None:
    pair = combine(Material(0.7, 0.1), Material(0.2, 0.08))
    assert pair.restitution == 0.7
    assert pair.friction == math.sqrt(0.1 * 0.08)


@given(SURFACES, SURFACES)
def test_it_does_not_matter_which_of_two_surfaces_comes_first(a: Material, b: Material) -> None:
    assert combine(a, b) == combine(b, a)


@given(SURFACES)
def test_a_surface_on_itself_is_itself(a: Material) -> None:
    assert combine(a, a).restitution == a.restitution
    assert combine(a, a).friction == pytest.approx(a.friction, rel=1e-15, abs=1e-150)


@given(SURFACES, st.floats(0.0, 1.0))
def test_nothing_rubs_on_a_frictionless_surface(a: Material, restitution: float) -> None:
    assert combine(a, Material(restitution, 0.0)).friction == 0.0


def test_the_density_is_that_of_a_board_drawn_in_pixels() -> None:
    assert pytest.approx(0.008 * 100 * 100) == REFERENCE_DENSITY


def test_restitution_is_known_of_six_pairs_of_bodies() -> None:
    ranges = {row.name: (row.low, row.high) for row in RESTITUTION}
    assert ranges == {
        "Coefficient of restitution": (0.0, 1.0),
        "Steel on steel": (0.80, 0.95),
        "Glass on glass": (0.93, 0.97),
        "Rubber on concrete": (0.75, 0.85),
        "Tennis ball on court": (0.70, 0.75),
        "Clay (putty)": (0.0, 0.10),
        "Billiard balls": (0.92, 0.98),
    }
    assert all(0.0 <= row.low < row.high <= 1.0 and row.note for row in RESTITUTION)


def test_gravity_is_known_on_four_worlds() -> None:
    assert dict(GRAVITY) == {"Earth": 9.81, "Moon": 1.62, "Mars": 3.72, "Jupiter": 24.79}
    assert GRAVITY["Earth"] == EARTH_GRAVITY
