"""Paths in pieces, decoded and drawn by the module that the page uses."""

import json
from functools import partial
from typing import Any

import msgspec
import numpy as np
import pytest
from playwright.sync_api import Error

from app import segments
from app.protocol import Extent
from app.room import DropCommand, Room
from engine import Board, drop
from tests.browser.conftest import ROOT, Run

GOLDEN = json.loads((ROOT / "tests" / "golden" / "segments.json").read_text())
SCALE = GOLDEN["scale"]
LAW = {name: SCALE[name] for name in ("gravity", "drag")}

DECODE = """({ decodeSegments }, { hex, scale }) => {
  const bytes = Uint8Array.from(hex.match(/../g) ?? [], (pair) => parseInt(pair, 16));
  return decodeSegments(bytes.buffer, scale);
}"""


@pytest.fixture
def segments_js(run: Run) -> Run:
    """Calls a JavaScript function with the module segments.js and an argument."""
    return partial(run, "segments.js")


def as_page(piece: dict[str, Any]) -> dict[str, Any]:
    """A golden piece as the page names things."""
    form = {name: value for name, value in piece.items() if name not in ("ball", "bend")}
    ax, ay = piece["bend"] or (None, None)
    return {**form, "id": piece["ball"], **({} if ax is None else {"ax": ax, "ay": ay})}


def page_scale(scale: segments.Scale) -> dict[str, Any]:
    return {
        "extent": msgspec.to_builtins(scale.extent),
        "velocityScale": scale.velocity_scale,
        "spinScale": scale.spin_scale,
        "rate": scale.tick_rate,
    }


def golden_scale() -> dict[str, Any]:
    given = dict(SCALE)
    return page_scale(segments.Scale(Extent(**given.pop("extent")), **given))


def test_golden_frames_decode_to_the_last_bit(segments_js: Run) -> None:
    for example in GOLDEN["frames"]:
        decoded = segments_js(DECODE, {"hex": example["hex"], "scale": golden_scale()})
        for name in ("tick", "seq", "full"):
            assert decoded[name] == example[name]
        assert decoded["flights"] == [as_page(piece) for piece in example["flights"]]
        assert decoded["curves"] == [as_page(piece) for piece in example["curves"]]


def test_golden_pieces_are_drawn_where_they_should(segments_js: Run) -> None:
    for example in GOLDEN["frames"]:
        pieces = [as_page(p) for p in example["flights"] + example["curves"] for _ in range(2)]
        drawn = segments_js(
            """({ piecePose }, { pieces, times, law }) =>
              pieces.map((piece, i) => piecePose(piece, times[i], law))""",
            {"pieces": pieces, "times": [d["at"] for d in example["drawn"]], "law": LAW},
        )
        for pose, wanted in zip(drawn, example["drawn"], strict=True):
            mine = [pose["x"], pose["y"], pose["angle"]]
            assert mine == pytest.approx(wanted["pose"], 1e-12)


@pytest.mark.parametrize(
    ("hex_bytes", "said"),
    [
        ("", "shorter than their header"),
        ("50" + "00" * 15, "start with 80"),
        ("5301" + "00" * 14, "version 1"),
        (GOLDEN["frames"][0]["hex"] + "00", "35 bytes, not 34"),
    ],
)
def test_damaged_frames_are_refused(segments_js: Run, hex_bytes: str, said: str) -> None:
    with pytest.raises(Error, match=said):
        segments_js(DECODE, {"hex": hex_bytes, "scale": golden_scale()})


@pytest.mark.parametrize("name", ["triangle-8", "triangle-16", "galton"])
def test_a_whole_drop_is_drawn_true(segments_js: Run, name: str) -> None:
    board = Board.preset(name)
    room = Room("r", board, tick_rate=60, max_balls=1)
    room.watch_segments(True)
    for _ in range(30):
        room.world.step()
    start = room.drop(DropCommand(42)).tick / 60
    frames = []
    while room.awake:
        room.step(watched=True)
        frame = room.segments()
        if frame is not None:
            frames.append(frame.hex())
    alone = drop(board, 42)
    times = np.arange(0.0, alone.duration, 1.0 / 120.0)
    drawn = segments_js(
        """({ decodeSegments, PiecePath }, { frames, scale, law, times }) => {
          const path = new PiecePath(law);
          for (const hex of frames) {
            const bytes = Uint8Array.from(hex.match(/../g), (pair) => parseInt(pair, 16));
            const { flights, curves } = decodeSegments(bytes.buffer, scale);
            for (const piece of [...curves, ...flights, ...flights]) path.add(piece);
          }
          return times.map((t) => path.poseAt(t)).map(({ x, y }) => [x, y]);
        }""",
        {
            "frames": frames,
            "scale": page_scale(room.scale),
            "law": {"gravity": board.gravity, "drag": board.drag},
            "times": (start + times).tolist(),
        },
    )
    states = alone.states(times)
    off = np.abs(np.array(drawn) - np.stack([states["x"], states["y"]], axis=1))
    assert off.max() <= 4e-4  # m: a twenty-fifth of a pixel at 100 px/m


def test_a_path_waits_for_its_first_piece_and_stops_at_its_end(
    segments_js: Run,
) -> None:
    seen = segments_js(
        """({ PiecePath }, law) => {
          const path = new PiecePath(law);
          const before = [path.known, path.start];
          path.add({ t: 10, x: 0, y: 0, vx: 1, vy: 0, angle: 0, spin: 0 });
          path.finish(10.5);
          return { before, known: path.known, start: path.start,
            early: path.poseAt(9).x, late: path.poseAt(99).x, end: path.poseAt(10.5).x,
            line: path.line().length };
        }""",
        {"gravity": 9.81, "drag": 0.0},
    )
    assert seen["before"] == [False, float("inf")]
    assert (seen["known"], seen["start"], seen["early"]) == (True, 10, 0)
    assert seen["late"] == seen["end"] == 0.5
    assert seen["line"] == 61
