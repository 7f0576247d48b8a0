"""A server that stood still says so once, and for how long."""

import contextlib
import logging

import pytest

from plinko.app.ops import stalls


class Machine:
    """A machine's clocks; each look at them takes the next of these steps."""

    def __init__(self, *steps: tuple[float, float, float]) -> None:
        self.steps = list(steps)
        self.passed = self.unix = self.worked = 0.0

    async def sleep(self, _: float) -> None:
        if not self.steps:
            raise StopAsyncIteration
        passed, unix, worked = self.steps.pop(0)
        self.passed, self.unix, self.worked = (
            self.passed + passed, self.unix + unix, self.worked + worked,
        )  # fmt: skip

    async def watched(self) -> None:
        with contextlib.suppress(RuntimeError, StopAsyncIteration):
            await stalls.watch(
                clock=lambda: self.passed,
                unix=lambda: self.unix,
                worked=lambda: self.worked,
                sleep=self.sleep,
            )


@pytest.mark.parametrize(
    ("step", "logged"),
    [
        ((0.5, 0.5, 0.1), []),
        ((2.4, 2.4, 0.1), []),
        ((5.5, 5.5, 0.0), [("the server stood still", 5.0, 0.0)]),
        ((9.5, 9.5, 9.1), [("the server stood still", 9.0, 9.1)]),
        ((0.5, -3599.5, 0.0), [("the machine's clock was set", -3600.0, None)]),
    ],
    ids=["on time", "a little late", "stopped", "computed", "the clock was set back"],
)
async def test_a_line_says_how_long_the_server_stood_still(
    step: tuple[float, float, float],
    logged: list[tuple[str, float, float | None]],
    caplog: pytest.LogCaptureFixture,
) -> None:
    with caplog.at_level(logging.WARNING):
        await Machine((0.5, 0.5, 0.0), step, (0.5, 0.5, 0.0)).watched()
    found = [(each.getMessage(), vars(each)["seconds"], vars(each).get("computed"))
             for each in caplog.records]  # fmt: skip
    assert found == logged
