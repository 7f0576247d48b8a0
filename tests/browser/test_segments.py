"""Paths in pieces, decoded and drawn by the module that the page uses."""

import json
from functools import partial
from typing import Any

import msgspec
import pytest
from playwright.sync_api import Error

from app import segments
from app.protocol import Extent
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
    return partial(run, "net/segments.js")


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
