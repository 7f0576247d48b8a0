"""The engine agrees with the literature: quick variants of `python -m benchmarks literature`."""

import math
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.contestants.event_driven import Billiards, Ours
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section
from benchmarks.literature import literature, lorentz, photon, siam, textbook
from benchmarks.literature.finding import Estimate, with_error
from benchmarks.scenes.touching import DT, gas

QUICK = Effort(quick=True, rounds=1, node=False)


@pytest.fixture(scope="module")
def section() -> Section:
    return literature.run(QUICK)


def rows(section: Section, key: str, part: str) -> list[dict[str, Any]]:
    found = [row for row in section.data[key] if part in row["case"]]
    assert found
    return found


@pytest.mark.parametrize("spacing", [2.1, 3.0, 6.0, 50.0])
def test_a_two_disc_orbit_has_the_multiplier_of_the_textbook(spacing: float) -> None:
    assert textbook.orbit_multiplier(spacing, 1.0).apart < 1e-12
    assert textbook.orbit_multiplier(0.1 * spacing, 0.1).apart < 1e-12


def test_double_precision_loses_eleven_of_the_photon_s_digits() -> None:
    found = siam.in_double_precision()
    assert found.reflections == 14
    assert 1e-7 < found.error < found.estimate < 1e-4


def test_the_lorentz_gas_has_its_free_path_and_lyapunov_exponent(section: Section) -> None:
    for row in rows(section, "lorentz", "mean free path") + rows(section, "lorentz", "Lyapunov"):
        assert row["apart"] < 4.0, row  # standard errors


def test_the_lorentz_gas_diffuses_as_machta_and_zwanzig_say(section: Section) -> None:
    """The estimate holds within a tenth at the narrowest gap, and less closely at wider gaps."""
    for found, most in zip(section.data["lorentz_diffusion"], (0.1, 0.4, 0.4, 0.6), strict=True):
        ratio = found["value"] / lorentz.machta_zwanzig(found["gap"])
        slack = 4.0 * found["error"] / lorentz.machta_zwanzig(found["gap"])
        assert 1.0 - most - slack < ratio < 1.0 + most + slack, found


def test_balls_of_the_elastic_galton_board_gain_speed_as_known(section: Section) -> None:
    speed, depth = section.data["galton"]
    assert float(speed["found"].split("(")[0]) == pytest.approx(1.0 / 3.0, abs=0.06)
    assert float(depth["found"].split("(")[0]) == pytest.approx(2.0 / 3.0, abs=0.12)
    (table,) = (table for table in section.tables if "Galton" in table.title)
    assert "came back up" in table.notes[0]


def test_the_figures_are_drawn(section: Section, tmp_path: Path) -> None:
    assert list(section.plots) == ["bench-digits.png", "bench-galton-board.png"]
    for name, draw in section.plots.items():
        draw(str(tmp_path / name))
        assert (tmp_path / name).stat().st_size > 20_000


def test_the_photon_s_digits_are_proven_as_many_as_are_asked_for() -> None:
    for digits in (5, 12, 40, 79):
        found = photon.with_digits(digits)
        assert found.digits == digits
        assert found.text == f"{Decimal(siam.TRUTH):.{digits}f}"
        assert found.reflections == 14
    longer = photon.with_digits(400)
    assert longer.text.startswith(siam.TRUTH[:-1])
    assert len(longer.text) == 402
    assert photon.with_bits(24, 5) is None, "too few bits decide nothing, and claim nothing"


def test_a_place_is_proven_to_30_digits_where_doubles_have_12(
    section: Section,
) -> None:
    drops = section.data["digits"]["drops"]
    proven = [point["error"] for point in drops if point["way"] == "certified"]
    (double,) = (point["error"] for point in drops if point["way"] == "double")
    assert 1e-17 < double < 1e-9
    assert min(proven) < 1e-30
    assert proven == sorted(proven, reverse=True)


def test_an_estimate_says_its_error_in_its_last_digit() -> None:
    assert with_error(1.76049, 0.0007) == "1.7605(7)"
    assert with_error(0.6667, 0.012) == "0.67(1)"
    found = Estimate.of(np.array([1.0, 2.0, 3.0, 4.0]))
    assert found.value == 2.5
    assert found.error == pytest.approx(math.sqrt(5.0 / 3.0) / 2.0)
    assert found.off(2.5 + 2.0 * found.error) == pytest.approx(2.0)


def test_the_arena_moves_an_elastic_gas_as_event_driven_codes_do() -> None:
    scene = gas(30)
    ours, other = Ours(scene), Billiards(scene)
    ours.run(6 * DT)
    other.run(6 * DT)
    assert ours.impacts() == other.impacts() > 60
    assert ours.places() == pytest.approx(other.places(), abs=1e-10)
    assert ours.velocities() == pytest.approx(other.velocities(), abs=1e-8)


def test_an_impact_s_cost_is_compared_with_an_event_driven_code(section: Section) -> None:
    (cost,) = (table for table in section.tables if table.title.startswith("Cost of an impact"))
    assert [row[0] for row in cost.rows] == [Ours.name, Billiards.name]
    assert section.data["gas"]["apart"][0]["apart"] < 1e-9
