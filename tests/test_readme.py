"""The README shows what its commands print, its pictures are what they draw, its links lead on."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.readme import (
    IMAGES,
    README,
    ROOT,
    Example,
    Runner,
    examples,
    runner,
    without_measurements,
)

TEXT = README.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def run() -> Iterator[Runner]:
    with runner() as ready:
        yield ready


def test_there_are_examples_of_every_kind() -> None:
    found = examples(TEXT)
    assert any(example.is_program for example in found)
    assert any("curl" in example.code for example in found)
    assert {"drop", "render", "simulate", "verify"} <= {
        word for example in found for word in example.code.split()
    }


def test_every_example_prints_what_the_readme_says(run: Runner) -> None:
    """In order and in one test, as later commands read files that earlier ones wrote."""
    for example in examples(TEXT):
        printed = run.run(example)
        assert without_measurements(printed) == without_measurements(example.says), example.code


def test_the_pictures_are_those_that_the_commands_draw(run: Runner) -> None:
    drawn = [example for example in examples(TEXT) if "plinko render" in example.code]
    assert drawn
    for example in drawn:
        _draw_and_compare(run, example)


def _draw_and_compare(run: Runner, example: Example) -> None:
    run.run(example)
    name = re.search(rf"{IMAGES}/\S+", example.code)
    assert name
    with Image.open(run.folder / name[0]) as new, Image.open(ROOT / name[0]) as kept:
        assert new.size == kept.size
        frames = getattr(new, "n_frames", 1)
        assert frames == getattr(kept, "n_frames", 1)
        for frame in {0, frames // 2, frames - 1}:
            new.seek(frame)
            kept.seek(frame)
            pictures = [np.asarray(image.convert("RGB")).astype(int) for image in (new, kept)]
            # Another version of the image library may round otherwise, but draws the same.
            assert abs(pictures[0] - pictures[1]).mean() < 1.0


@pytest.mark.parametrize("document", sorted(ROOT.glob("*.md")) + sorted(ROOT.glob("docs/*.md")))
def test_links_and_pictures_lead_somewhere(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"", text):
        link = next(filter(None, target)).split("#")[0]
        if link and not re.match(r"https?:|mailto:", link):
            assert (document.parent / link).exists(), f"{document.name}: {link}"
