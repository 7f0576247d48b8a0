"""The worlds: honest physics, no dull table, payouts that rise to the sides and with the risk."""

from itertools import pairwise

import pytest

from plinko.engine import Board, drop_many
from plinko.engine.board import payouts
from plinko.engine.board.materials import GRAVITY, RESTITUTION
from plinko.engine.board.presets import TUNING, VARIANTS, Variant
from plinko.engine.board.worlds import TABLE_GRAVITY, WORLDS
from plinko.engine.payouts.record import odds_of_record
from tests.long import tries

WORLD_PRESETS = [Variant(world, rows, "medium").name for world in WORLDS for rows in payouts.ROWS]
MEASURED = {row.name.split()[0].lower(): row for row in RESTITUTION}


def test_a_planet_has_its_own_gravity_and_its_own_air() -> None:
    for planet in ("earth", "moon", "mars", "jupiter"):
        assert WORLDS[planet].gravity == GRAVITY[planet.capitalize()]
    assert WORLDS["earth"].gravity == 9.81
    assert WORLDS["moon"].drag == 0.0
    # Mars has 1/60 of the density of Earth's air.
    assert WORLDS["mars"].drag == pytest.approx(WORLDS["earth"].drag / 60, rel=0.05)
    assert WORLDS["jupiter"].drag > WORLDS["earth"].drag


@pytest.mark.parametrize("material", ["glass", "steel", "rubber"])
def test_a_material_has_its_measured_restitution_on_the_house_table(material: str) -> None:
    world = WORLDS[material]
    assert MEASURED[material].low <= world.restitution <= MEASURED[material].high
    assert (world.gravity, world.size) == (TABLE_GRAVITY, 1.0)


def test_no_two_worlds_move_a_ball_alike() -> None:
    assert len(set(WORLDS.values())) == len(WORLDS)
    house, jupiter = TUNING["triangle-16"], WORLDS["jupiter"]
    assert (house.drag, house.restitution) != (jupiter.drag, jupiter.restitution)
    falls = {}
    for name in ["triangle-16", *(f"{world}-16" for world in WORLDS)]:
        falls[name] = round(float(drop_many(name, range(200)).duration.mean()), 3)
    assert len(set(falls.values())) == len(falls), falls


def test_a_ball_falls_for_nine_seconds_on_average_at_most() -> None:
    for name in WORLD_PRESETS:
        found = drop_many(name, range(tries(300, 20_000)))
        assert found.duration.mean() < 9.0, name
        assert found.duration.max() < 60.0, name


def test_a_thousand_balls_on_sixteen_rows_hit_seven_bins_and_more() -> None:
    for world in WORLDS:
        found = drop_many(f"{world}-16", range(10**9, 10**9 + 1000)).histogram
        assert (found > 0).sum() >= 7, world


def test_payouts_rise_to_the_sides_and_with_the_risk() -> None:
    for name in WORLD_PRESETS:
        tables = [VARIANTS[name]._replace(risk=risk).name for risk in ("low", "medium", "high")]
        low, medium, high = (payouts.TABLES[table].half for table in tables)
        for half in (low, medium, high):
            assert all(outer >= inner for outer, inner in pairwise(half)), (name, half)
        assert low[0] < medium[0] < high[0], name
        assert low[-1] >= medium[-1] >= high[-1], name
        calm, even, wild = (odds_of_record(Board.preset(table))[0].volatility for table in tables)
        assert calm < even < wild, name


def test_the_start_and_the_walls_scale_with_the_board() -> None:
    moon, glass = Board.preset("moon-16"), Board.preset("glass-16")
    for large, small in zip(glass.pegs, moon.pegs, strict=True):
        assert small.x == pytest.approx(0.3 * large.x)
        assert small.y == pytest.approx(0.3 * large.y)
    assert moon.drop.jitter == pytest.approx(0.3 * glass.drop.jitter)
    assert (moon.width, moon.height) == pytest.approx((0.3 * glass.width, 0.3 * glass.height))
