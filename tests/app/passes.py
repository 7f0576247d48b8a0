"""Whole passes of the ticker, without a clock."""

from app.live.ticking.runner import Runner


def run_pass(runner: Runner, due: int = 1) -> bool:
    """Tick every awake room `due` times; returns whether a room is still awake."""
    *_, awake = runner.tick(due)
    return awake
