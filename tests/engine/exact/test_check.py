"""The solver checks its own paths: a drop with a false impact has no bin, and is never certain."""

import pytest

from plinko.engine.exact.outcome import FALSE_PATH, REASONS
from tests.kit.python import run_python

DROP = """
from plinko.engine import drop
from plinko.engine.drops.certainty import certainty_of
from plinko.engine.exact import free_flight, two_contacts

{fault}
d = drop("triangle-8", 42)
print(d.bin, d.score, certainty_of(d.trajectory).certain, d.unsettled)
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


@pytest.mark.parametrize("fault", [LATE, LIVELY], ids=["off the surface", "gains energy"])
def test_a_drop_with_a_false_impact_ends_as_a_solver_error(fault: str) -> None:
    found = run_python(DROP.format(fault=fault), NUMBA_DISABLE_JIT="1")
    assert found.strip() == f"None 1.0 False {REASONS[FALSE_PATH]}"


def test_the_same_drop_without_a_fault_lands() -> None:
    found = run_python(DROP.format(fault=""), NUMBA_DISABLE_JIT="1")
    assert found.split()[0] == "6"
