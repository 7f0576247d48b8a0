"""The solver checks its own paths: a drop with a false impact has no bin, and is never certain."""

from plinko.engine.exact.outcome import FALSE_PATH, REASONS
from tests.kit.python import run_python

DROP = """
from plinko.engine import drop
from plinko.engine.drops.certainty import certainty_of
from plinko.engine.exact import free_flight

def show():
    d = drop("triangle-8", 42)
    print(d.bin, d.score, certainty_of(d.trajectory).certain, d.unsettled, sep=", ")

show()
"""

LATE = """
search = free_flight.next_impact
def late(*args):
    s, item, side = search(*args)
    return (s + 1e-8 if item >= 0 else s), item, side
free_flight.next_impact = late
"""

LIVELY = """
law = free_flight.bounce
def lively(*args):
    vx, vy, omega, sticks = law(*args)
    return 2.0 * vx, 2.0 * vy, omega, sticks
free_flight.bounce = lively
"""


def test_a_drop_with_a_false_impact_ends_as_a_solver_error() -> None:
    """An impact off the surface, then one that gains energy; without a fault the ball lands."""
    mend = "free_flight.next_impact = search\n"
    program = f"{DROP}{LATE}show()\n{mend}{LIVELY}show()\n"
    right, *wrong = run_python(program, NUMBA_DISABLE_JIT="1").splitlines()
    assert right.startswith("6, ")
    assert wrong == [f"None, 1.0, False, {REASONS[FALSE_PATH]}"] * 2
