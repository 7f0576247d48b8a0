"""A pass of the ticker in one go, without a clock."""

from app.live.ticking.runner import Runner


def run_pass(runner: Runner, due: int = 1) -> bool:
    """Tick every room that is awake so often; whether one still is."""
    *_, awake = runner.tick(due)
    return awake
