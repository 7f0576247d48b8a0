"""The pictures' WebAssembly matches its source, and paints the same bytes as Python."""

import os
from typing import Any, cast

import numpy as np
import pytest

from plinko.app.render.parts.balls import paint_balls, paint_trail, style_of
from plinko.app.render.raster import make, pixels
from plinko.engine.jit import machine_code, source_hash
from plinko.engine.jit.decorator import EntryKernel


def test_the_artifact_was_made_from_the_kernels_that_are_there() -> None:
    made_from = source_hash.read(make.ARTIFACT.read_bytes())
    fresh = source_hash.current_beside(make.KERNELS)
    assert source_hash.is_of(fresh, made_from), "kernels have changed since: `make kernels`"


@pytest.mark.long("numba compiles for a while")
def test_the_artifact_made_again_is_the_same() -> None:
    assert make.made() == make.ARTIFACT.read_bytes()


def painted(width: int, height: int) -> list[bytes]:
    """A picture of trails and balls, some beyond its edges, and its indices of colours."""
    picture = np.full((height, width, 3), 90, np.uint8)
    style, lowest = style_of(5.0, "light"), height - 6
    xs, ys = np.array([-2.0, 20.3, 40.7, 1e300]), np.array([10.2, -3.0, height - 4.0, 1e300])
    for x, y in zip(xs, ys, strict=True):
        paint_trail(picture, np.array([[x, y], [x + 6.0, y - 9.5], [x + 7.0, y]]), style, lowest)
    paint_balls(picture, xs, ys, np.linspace(0.0, 3.0, 4), style, lowest)
    points = np.array([[-3.0, 4.0], [20.3, 12.5], [20.3, 12.5], [60.0, 50.0]])
    coats = np.array([[4.6, 0.5, 9.0, 9.0, 9.0], [2.4, 1.0, 250.0, 240.0, 200.0]])
    pixels.paint_line(picture, points, np.array([[1.0] * 3, [0.5, 0.7, 1.0]]), coats)
    strokes = np.array([[8.2, 8.1, 8.2, 8.1, 3.3, 0.6], [-9.0, 20.0, 70.0, 25.0, 1.2, 1.0]])
    pixels.paint_strokes(picture, strokes, np.array([[200.0, 0.0, 0.0], [0.0, 0.0, 90.0]]))
    colours = np.unique(picture.reshape(-1, 3), axis=0)[::9]
    colours = colours[np.argsort(colours[:, 1], kind="stable")]
    indices, keys = np.zeros(picture.shape[:2], np.uint8), np.full(64, -1, np.int32)
    pixels.index_pixels(picture, colours, keys, np.zeros(64, np.uint8), indices)
    return [picture.tobytes(), indices.tobytes()]


@pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")
def test_machine_code_gives_the_bytes_that_python_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    kernels = [
        cast("EntryKernel[Any, Any]", each)
        for each in (
            pixels.paint_balls,
            pixels.paint_trail,
            pixels.paint_line,
            pixels.paint_strokes,
            pixels.index_pixels,
        )
    ]
    assert {each.name for each in kernels} == set(machine_code.modules_beside(make.KERNELS))
    expected = painted(50, 36)
    for each in kernels:
        monkeypatch.setattr(each, "machine_code", each.function)
    assert painted(50, 36) == expected


def test_only_rows_near_a_shape_may_change() -> None:
    picture = np.zeros((200, 60, 3), np.uint8)
    x, y = np.array([30.0]), np.array([100.0])
    paint_balls(picture, x, y, np.zeros(1), style_of(8.0, "dark"), 150)
    rows = np.flatnonzero(picture.max(axis=(1, 2)))
    assert 90 <= rows.min() <= 93
    assert 107 <= rows.max() <= 117
