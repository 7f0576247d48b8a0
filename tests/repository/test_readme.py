"""Pages show what their examples print and draw, and their links work."""

import hashlib
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plinko
from plinko.app.fairness.seeds import draw_mac, drop_mac
from plinko.app.rooms.canonical import canonical
from plinko.engine import drop_many
from tests.long import tries
from tools import reference
from tools.readme import (
    INDEX,
    PAGES,
    QUICKSTART,
    README,
    ROOT,
    Example,
    Runner,
    examples,
    pictures,
    runner,
    without_measurements,
)

TEXT = README.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def run() -> Iterator[Runner]:
    with runner() as ready:
        yield ready


@pytest.mark.long  # the page of pictures draws the README's picture again in every format
@pytest.mark.parametrize(
    "page", tries((README, INDEX, QUICKSTART), PAGES), ids=lambda page: page.name
)
def test_every_example_prints_and_draws_what_its_page_shows(run: Runner, page: Path) -> None:
    """All examples of a page in order, because later ones read files that earlier ones wrote."""
    for example in quick(page):
        printed = run.run(example)
        assert without_measurements(printed) == without_measurements(example.says), example.code
        for name in pictures(example):
            _compare(run, name)


def quick(page: Path) -> list[Example]:
    """The examples of a page, without those of a million drops, which take too long."""
    found = examples(page.read_text(encoding="utf-8"))
    return [example for example in found if "1000000" not in example.code]


def _compare(run: Runner, name: str) -> None:
    with Image.open(run.folder / name) as new, Image.open(ROOT / name) as kept:
        assert new.size == kept.size
        frames = getattr(new, "n_frames", 1)
        assert frames == getattr(kept, "n_frames", 1)
        for frame in {0, frames // 2, frames - 1}:
            new.seek(frame)
            kept.seek(frame)
            pictures = [np.asarray(image.convert("RGB")).astype(int) for image in (new, kept)]
            # Another version of the image library may round differently, but draws the same.
            assert abs(pictures[0] - pictures[1]).mean() < 1.0


@pytest.mark.parametrize("document", sorted(ROOT.glob("*.md")) + sorted(ROOT.glob("docs/*.md")))
def test_links_and_pictures_lead_somewhere(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"", text):
        link = next(filter(None, target)).split("#")[0]
        if link and not re.match(r"https?:|mailto:", link):
            assert (document.parent / link).exists(), f"{document.name}: {link}"


def test_the_script_of_the_page_on_batches_runs_as_a_file(tmp_path: Path) -> None:
    """It runs with fewer drops, in processes that import the file."""
    page = (ROOT / "docs" / "batches.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    script = tmp_path / "batch.py"
    script.write_text(code.replace("1_000_000", "70_000").replace("local:4", "local:2"))
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout == f"{drop_many('triangle-16', 70_000).digest}\n"


def test_the_python_reference_has_every_name_from_the_sources() -> None:
    names = [name for group in reference.GROUPS.values() for name in group]
    assert sorted(name for name in names if "." not in name) == sorted(plinko.__all__)
    shown = re.findall(r"^### (.*)$", reference.text(), re.MULTILINE)
    assert [name.rpartition(".")[2] for name in shown] == [
        name.rpartition(".")[2] for name in names
    ]


def test_the_vectors_of_fair_sessions_are_those_of_the_sample() -> None:
    page = (ROOT / "docs" / "fair-sessions.md").read_text(encoding="utf-8")
    sample = json.loads((ROOT / "tests" / "golden" / "session.json").read_text(encoding="utf-8"))
    server, client = (bytes.fromhex(sample[name]) for name in ("server_seed", "client_seed"))
    receipts = [each["receipt"] for each in sample["drops"]]
    digest = bytes.fromhex(receipts[0]["board_digest"])
    leaf = canonical(receipts[0])
    for value in (
        server.hex(),
        client.hex(),
        hashlib.sha256(server).hexdigest(),
        hashlib.sha256(client).hexdigest(),
        (b"plinko drop 1\n" + client + bytes(8) + digest).hex(),
        drop_mac(server, client, 0, digest).hex(),
        *(receipt["seed"] for receipt in receipts),
        leaf.decode(),
        hashlib.sha256(b"\0" + leaf).hexdigest(),
    ):
        assert value in page


def test_the_vectors_of_a_draw_are_those_of_its_sample() -> None:
    page = (ROOT / "docs" / "fair-sessions.md").read_text(encoding="utf-8")
    file = ROOT / "tests" / "golden" / "draw_session.json"
    sample = json.loads(file.read_text(encoding="utf-8"))
    server, client = (bytes.fromhex(sample[name]) for name in ("server_seed", "client_seed"))
    first, weights = sample["drops"][0], sample["draw"]["weights"]
    digest = bytes.fromhex(first["receipt"]["board_digest"])
    mac = draw_mac(server, client, 0, digest)
    x, y = int.from_bytes(mac[:16], "big"), int.from_bytes(mac[16:24], "big")
    for line in (
        f"weights        {' '.join(map(str, weights))}",
        f"draw_digest    {hashlib.sha256(canonical(sample['draw'])).hexdigest()}",
        f"message        {(b'plinko draw 1' + bytes([10]) + client + bytes(8) + digest).hex()}",
        f"HMAC           {mac.hex()}",
        f"x              {x}",
        f"y              {y}",
        f"place          {x * sum(weights) >> 128}",
        f"bin            {first['result']['bin']}",
        f"seed           {first['receipt']['seed']}",
    ):
        assert f"\n{line}\n" in page
