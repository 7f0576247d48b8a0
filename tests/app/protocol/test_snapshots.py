"""Snapshots: golden bytes, errors by rounding and clamping, and damaged messages."""

import json
import math
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.app.protocol import messages, snapshots
from plinko.engine import Board
from tests.app.protocol.decoders import decode_snapshot

GOLDEN = Path(__file__).parents[2] / "golden"
SNAPSHOTS = json.loads((GOLDEN / "snapshots.json").read_text())["snapshots"]

EXTENT = messages.Extent(-4.0, 4.0, -1.0, 6.5)
SCALE = 1.0 / 1024.0
BODY = np.dtype([("id", "i4"), *[(name, "f8") for name in ("x", "y", "theta", "vx", "vy")]])


def bodies(rows: list[tuple[Any, ...]]) -> np.ndarray:
    return np.array(rows, BODY)


@pytest.mark.parametrize("golden", SNAPSHOTS, ids=lambda golden: golden["name"])
def test_golden_values_are_encoded_to_and_decoded_from_exactly_these_bytes(
    golden: dict[str, Any],
) -> None:
    extent = msgspec.convert(golden["extent"], messages.Extent)
    snapshot = decode_snapshot(bytes.fromhex(golden["hex"]), extent, golden["velocity_scale"])
    assert (snapshot.tick, snapshot.seq) == (golden["tick"], golden["seq"])
    names = snapshot.balls.dtype.names or ()
    decoded = [dict(zip(names, row, strict=True)) for row in snapshot.balls.tolist()]
    assert decoded == golden["balls"]
    rows = [tuple(ball[name] for name in BODY.names or ()) for ball in golden["balls"]]
    bounced = np.array([ball["bounced"] for ball in golden["balls"]], bool)
    data = snapshots.encode_snapshot(
        golden["tick"],
        golden["seq"],
        bodies(rows),
        bounced,
        extent,
        golden["velocity_scale"],
        np.array([ball["asleep"] for ball in golden["balls"]], bool),
    )
    assert data.hex() == golden["hex"]


number = st.floats(-1e3, 1e3)


@given(
    st.lists(
        st.tuples(
            st.integers(0, 2**31 - 1),
            st.floats(EXTENT.x_min, EXTENT.x_max),
            st.floats(EXTENT.y_min, EXTENT.y_max),
            number,
            st.floats(-31.9, 31.9),
            st.floats(-31.9, 31.9),
            st.booleans(),
        ),
        max_size=20,
    ),
    st.integers(0, 2**40),
    st.integers(0, 2**40),
)
def test_a_decoded_snapshot_is_off_by_half_a_step_at_most(
    balls: list[tuple[Any, ...]], tick: int, seq: int
) -> None:
    rows = bodies([ball[:6] for ball in balls])
    flags = np.array([ball[6] for ball in balls], bool)
    data = snapshots.encode_snapshot(tick, seq, rows, flags, EXTENT, SCALE)
    assert len(data) == 12 + 12 * len(balls)
    decoded = decode_snapshot(data, EXTENT, SCALE)
    assert decoded.tick == tick % 2**32
    assert decoded.seq == seq % 2**32
    assert (decoded.balls["id"] == rows["id"] % 65536).all()
    half = 0.5000001
    assert (np.abs(decoded.balls["x"] - rows["x"]) <= half * 8.0 / 65535).all()
    assert (np.abs(decoded.balls["y"] - rows["y"]) <= half * 7.5 / 65535).all()
    assert (np.abs(decoded.balls["vx"] - rows["vx"]) <= half * SCALE).all()
    assert (np.abs(decoded.balls["vy"] - rows["vy"]) <= half * SCALE).all()
    turned = np.remainder(decoded.balls["theta"] - rows["theta"] + math.pi, 2 * math.pi) - math.pi
    assert (np.abs(turned) <= half * 2 * math.pi / 256 + 1e-9).all()
    assert (decoded.balls["bounced"] == flags).all()


@given(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False, width=32)] * 4))
def test_what_lies_outside_the_ranges_is_clamped_to_their_edge(
    values: tuple[float, float, float, float],
) -> None:
    x, y, vx, vy = values
    rows = bodies([(1, x, y, 0.0, vx, vy)])
    data = snapshots.encode_snapshot(0, 0, rows, np.zeros(1, bool), EXTENT, SCALE)
    ball = decode_snapshot(data, EXTENT, SCALE).balls[0]
    assert ball["x"] == pytest.approx(min(max(x, -4.0), 4.0), abs=1e-4)
    assert ball["y"] == pytest.approx(min(max(y, -1.0), 6.5), abs=1e-4)
    top = 32767 * SCALE
    assert ball["vx"] == pytest.approx(min(max(vx, -top), top), abs=SCALE)
    assert ball["vy"] == pytest.approx(min(max(vy, -top), top), abs=SCALE)


@pytest.mark.parametrize("name", ["triangle-8", "triangle-16", "classic", "galton"])
def test_the_velocity_range_holds_the_fastest_fall_of_a_board(name: str) -> None:
    board = Board.preset(name)
    extent = messages.Extent(*board.extent)
    scale = snapshots.velocity_scale_of(board, extent)
    assert 32767 * scale >= 2 * math.sqrt(2 * board.gravity * (extent.y_max - extent.y_min))
    assert math.frexp(scale)[0] == 0.5, "a power of two, so that decoding adds no rounding"
