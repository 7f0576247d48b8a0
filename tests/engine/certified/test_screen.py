"""A screen omits only surfaces that the ball does not touch before the screen's time."""

from fractions import Fraction

import numpy as np
from flint import arb

from plinko.engine.certified.balls import Proof, UndecidedError, precision
from plinko.engine.certified.flight import Flight
from plinko.engine.certified.reach import NEVER, rebound_reach
from plinko.engine.certified.scene import scene_of
from plinko.engine.certified.trace import trace
from plinko.engine.physics.flight import basis
from tests.long import tries
from tools.oracle.random_scenes import random_scene


def test_no_surface_is_touched_earlier_than_the_screen_says() -> None:
    """On random boards, the screen has listed every surface that a ball's flight overlaps."""
    looked = 0
    for seed in range(tries(4, 60)):
        board, x = random_scene(seed)
        with precision(160):
            scene = scene_of(board, 160)
            try:
                path = trace(board, arb(x), 160, Proof(2000))
            except UndecidedError:  # undecided: no flights to check
                continue
            for event in path.events[:12]:
                course = Flight(scene, event.state).course
                found, end = scene.screen.reaches(course, 0.0, None)
                if end == NEVER:
                    continue
                reached = {surface: time for time, surface in found}
                for s in np.linspace(0.0, end, 40).tolist():
                    _, phi, psi = basis(course.drag, s)
                    x_at = course.state[0] + course.state[2] * s + course.state[4] * psi
                    y_at = course.state[1] + course.state[3] * s + course.state[5] * psi
                    assert phi >= 0.0
                    for circle in scene.circles:
                        apart = np.hypot(x_at - float(circle.x), y_at - float(circle.y))
                        if apart < float(circle.reach) - 1e-12:
                            assert reached.get(circle, NEVER) <= s
                    looked += 1
    assert looked > 100


def test_a_parabola_that_stays_positive_is_never_reached() -> None:
    assert rebound_reach(1.0, 1.0, 0.0, 5.0) == NEVER
    assert rebound_reach(1.0, -2.0, 2.5, 5.0) == NEVER
    assert 0.99 < rebound_reach(1.0, -1.0, 0.0, 5.0) <= Fraction(1)
