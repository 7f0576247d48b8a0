"""The machine code of pictures: made from what is there, and the bytes that Python gives."""

import os
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import pytest

from app.render.parts.balls import look_of, paint_balls, paint_trail
from app.render.raster import make, pixels
from engine.jit import machine_code, stamp
from engine.jit.decorator import EntryKernel

Pixels = npt.NDArray[np.uint8]


def test_the_artifact_was_made_from_the_kernels_that_are_there() -> None:
    made_from = stamp.read(make.ARTIFACT.read_bytes())
    fresh = stamp.current_beside(make.KERNELS)
    assert stamp.is_of(fresh, made_from), "kernels have changed since: `make kernels`"


@pytest.mark.long("numba compiles for a while")
def test_the_artifact_made_anew_is_the_one_that_is_there() -> None:
    assert make.made() == make.ARTIFACT.read_bytes()


def painted(width: int, height: int) -> list[bytes]:
    """A picture with trails and balls, some of them beyond its edges, and its colours' indices."""
    picture = np.full((height, width, 3), 90, np.uint8)
    look, lowest = look_of(5.0, "light"), height - 6
    xs, ys = np.array([-2.0, 20.3, 40.7, 1e300]), np.array([10.2, -3.0, height - 4.0, 1e300])
    for x, y in zip(xs, ys, strict=True):
        paint_trail(picture, np.array([[x, y], [x + 6.0, y - 9.5], [x + 7.0, y]]), look, lowest)
    paint_balls(picture, xs, ys, np.linspace(0.0, 3.0, 4), look, lowest)
    colours = np.unique(picture.reshape(-1, 3), axis=0)[::9].copy()
    indices, keys = np.zeros(picture.shape[:2], np.uint8), np.full(64, -1, np.int32)
    pixels.index_pixels(picture, colours, keys, np.zeros(64, np.uint8), indices)
    return [picture.tobytes(), indices.tobytes()]


@pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")
def test_machine_code_gives_the_bytes_that_python_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    kernels = [
        cast("EntryKernel[Any, Any]", each)
        for each in (pixels.paint_balls, pixels.paint_trail, pixels.index_pixels)
    ]
    assert {each.name for each in kernels} == set(machine_code.modules_beside(make.KERNELS))
    expected = painted(50, 36)
    for each in kernels:
        monkeypatch.setattr(each, "machine_code", each.function)
    assert painted(50, 36) == expected


def test_only_rows_near_a_shape_may_change() -> None:
    picture = np.zeros((200, 60, 3), np.uint8)
    x, y = np.array([30.0]), np.array([100.0])
    paint_balls(picture, x, y, np.zeros(1), look_of(8.0, "dark"), 150)
    rows = np.flatnonzero(picture.max(axis=(1, 2)))
    assert 90 <= rows.min() <= 93
    assert 107 <= rows.max() <= 117
