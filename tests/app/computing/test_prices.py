"""Prices of requests: those that would occupy a worker for minutes are refused."""

import pytest

from plinko.app.computing import prices, tasks
from plinko.app.errors import CostError, response_for
from plinko.app.web.routes.drops.pictures import pixels_of
from plinko.engine import Board
from plinko.engine.parameters import Exact, make_solver
from tests.app.conftest import TINY
from tests.kit.presets import SAMPLE

BOARD = Board.preset("triangle-16")
WIDE = pixels_of(BOARD, 2048)  # pixels of the board's largest picture
PAGE = 760 * 840


def frames(seconds: float, fps: int) -> int:
    return int(min(seconds, 60.0) * fps) + 1


def test_animations_as_people_ask_for_them_are_drawn_and_the_largest_refused() -> None:
    for pixels, fps in ((PAGE, 30), (PAGE, 60), (WIDE, 10)):
        assert prices.animation(pixels, frames(6.0, fps)).check().seconds < 9.0
    for seconds in (1000.0, 6.0):  # they took 269 s and 23 s before they were refused
        price = prices.animation(WIDE, frames(seconds, 60))
        assert price.seconds > 10.0
        with pytest.raises(CostError, match="pixels x frames, and one request may take") as refused:
            price.check()
        assert f"{price.amount:.3g}" in str(refused.value)
        assert response_for(refused.value).status == 422
    # `classic` is tall: at 2,048 pixels its animation needed 330 MB; a worker has 256.
    tall = pixels_of(Board.preset("classic"), 2048)
    with pytest.raises(CostError, match=r"6\.5e\+06 pixels a frame.* 4\.2e\+06") as refused:
        prices.animation(tall, 2).check()
    assert refused.value.field == "width"


def test_a_stepped_drop_of_gigabytes_is_refused_before_it_starts() -> None:
    """1,000 s in steps of 0.1 ms would need 1.9 GB of memory."""
    with pytest.raises(CostError, match="1e\\+07 substeps"):
        prices.stepped_drop(1000.0 / 1e-4).check()
    hovering = Board.from_json({**TINY, "gravity": 2e-4})
    ask = tasks.Ask(hovering, 1, None, make_solver("stepped", 1e-4, 1, 0.5))
    with pytest.raises(CostError, match="substeps"):
        ask.drop()


@pytest.mark.parametrize("name", SAMPLE)
def test_single_drops_of_every_preset_are_computed(name: str) -> None:
    board = Board.preset(name)
    for solver in (Exact(), make_solver("stepped", 1e-4, 1, 0.5)):
        assert prices.one_drop(board, solver).check().seconds < 0.2


def test_many_drops_in_the_shortest_steps_are_refused() -> None:
    shortest = make_solver("stepped", 1e-4, 1, 0.5)
    with pytest.raises(CostError, match="drops x substeps") as refused:
        prices.many_drops(BOARD, 10_000, shortest).check()
    assert refused.value.field == "drops"
    assert prices.many_drops(BOARD, 10_000, Exact()).check().seconds < 2.0


def test_a_fall_takes_as_long_as_gravity_and_drag_say() -> None:
    falling = prices.fall_time(Board.from_json(TINY))
    assert falling == pytest.approx((2.0 * 2.0 / 9.81) ** 0.5)
    assert prices.fall_time(Board.from_json({**TINY, "drag": 50.0})) == pytest.approx(100.0 / 9.81)
