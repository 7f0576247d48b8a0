"""Places: the server's pictures have the same backdrops and pegs as the page."""

import json
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from plinko.app.render.parts import ground
from plinko.app.render.parts.board import light_of, paint_peg
from plinko.app.render.parts.ground import Place
from plinko.app.render.raster.canvas import Canvas
from plinko.app.render.theme import THEMES, at_place
from plinko.app.settings import static_directory
from tests.browser.conftest import Run

DATA = json.loads((static_directory() / "theme.json").read_text(encoding="utf-8"))
WIDTH, HEIGHT, START = 640, 560, 300  # px; balls start slightly left of the middle
BLOCK = 8  # px: the two painters smooth edges differently, so means of blocks are compared
PEG = 60.0  # px, larger than in any picture

# The page's backdrop around the plate, the plate, and a peg: the mean colour of each block.
_PAINTED = """
async ({ GROUNDS, SURROUNDINGS }, { place, width, height, x, peg, block }) => {
  const { lookOf } = await import("/js/paint/theme.js");
  const { paintPeg } = await import("/js/paint/peg.js");
  const data = await (await fetch("/theme.json")).json();
  const { palette: colours, shapes, ground, grounds } = lookOf(data, data.light, place);
  const ctx = new OffscreenCanvas(width, height).getContext("2d");
  const all = { x, y: 0, width, height, colours, rays: shapes.rays, grounds };
  const blocks = (pixels) => {
    const sums = new Float64Array((width / block) * (height / block) * 3);
    pixels.forEach((value, i) => {
      const [channel, x, y] = [i % 4, (i >> 2) % width, Math.floor((i >> 2) / width)];
      if (channel === 3) return;
      const at = Math.floor(y / block) * (width / block) + Math.floor(x / block);
      sums[3 * at + channel] += value / (block * block);
    });
    return Array.from(sums);
  };
  const paint = (behind, over) => {
    ctx.save();
    ctx.fillStyle = behind;
    ctx.fillRect(0, 0, width, height);
    over(ctx, all);
    ctx.restore();
    return blocks(ctx.getImageData(0, 0, width, height).data);
  };
  return [
    paint(colours.shoulder, SURROUNDINGS[ground]),
    paint(colours.board, GROUNDS[ground]),
    paint(colours.board, () => paintPeg(ctx, { x, y: height / 2, r: peg }, colours, shapes.peg)),
  ];
}
"""

Blocks = npt.NDArray[np.float64]


def blocks(pixels: Any) -> Blocks:
    """The mean colour of each block of a picture."""
    shape = (HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, 3)
    found: Blocks = np.asarray(pixels, np.float64).reshape(shape).mean(axis=(1, 3))
    return found


# The rays of the house table and of Earth are painted with the board.
@pytest.mark.parametrize(
    "name", [name for name, place in DATA["places"].items() if place["ground"] != "rays"]
)
def test_pictures_have_the_page_s_ground_and_pegs(run: Run, name: str) -> None:
    given = {
        "place": name,
        "width": WIDTH,
        "height": HEIGHT,
        "x": START,
        "peg": PEG,
        "block": BLOCK,
    }
    shape = (HEIGHT // BLOCK, WIDTH // BLOCK, 3)
    page = [np.reshape(found, shape) for found in run("paint/ground.js", _PAINTED, given)]
    theme = THEMES[at_place("light", f"{name}-16")]
    place = Place(float(START), 1.0, theme)
    empty = [
        Canvas.blank(WIDTH, HEIGHT, theme[colour]) for colour in ("shoulder", "board", "board")
    ]
    around, plate, peg = empty
    plain = [blocks(canvas.bytes()) for canvas in empty]
    ground.paint_surroundings(around, place)
    ground.paint_plate(plate, place)
    paint_peg(peg, (float(START), 0.5 * HEIGHT, PEG), theme, light_of(theme))
    for shown, canvas, before in zip(page, (around, plate, peg), plain, strict=True):
        drawn = blocks(canvas.bytes())
        printed = np.abs(shown - before).max(axis=-1) > 1.0
        assert printed.any(), "something is printed there"
        off = np.abs(drawn - shown)
        assert off.mean() < 0.5 + 0.02 * np.abs(shown - before).max(), "but for rounding"
        assert off.max() < 0.3 * np.abs(shown - before).max(), "in no place another thing"
