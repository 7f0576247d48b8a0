"""Drops on presets have had the same bits since version 4 of the physics."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from plinko.engine import Board, drop_many
from tests.kit.presets import SAMPLE
from tests.long import tries

RECORDED = json.loads(Path(__file__).with_name("trajectories.json").read_text(encoding="utf-8"))
"""By preset: SHA-256 over x_end, duration, bin and all impacts of the seeds 0 to 999."""


def trajectories(name: str) -> str:
    """The hash of a preset's drops, computed now."""
    found = hashlib.sha256()
    for one in drop_many(Board.preset(name), range(1000)):
        found.update(np.array([one.x_end, one.duration, one.bin]).tobytes())
        found.update(one.impacts.tobytes())
    return found.hexdigest()


@pytest.mark.long
@pytest.mark.parametrize("name", ["triangle-8", "classic", "galton", *tries([], SAMPLE)])
def test_a_preset_s_balls_go_where_they_went(name: str) -> None:
    assert trajectories(name) == RECORDED[name]


def test_every_preset_is_recorded() -> None:
    assert set(RECORDED) == set(SAMPLE)
