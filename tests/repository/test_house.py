"""A visitor finds a room by reading the tree: no folder is a hall, no file of the product long."""

import subprocess
from collections import defaultdict
from pathlib import PurePosixPath

import pytest

from tests.repository.architecture import ROOT

HALLS = ("engine", "app", "static/js", "benchmarks", "tests")

ENTRIES = 16
"""Files and folders in a folder at most."""

CHAPTERS = 23
"""In a hall itself, and among the tests of one, most of which are folders of their own."""

LINES = 400


def files() -> list[PurePosixPath]:
    listed = subprocess.run(["git", "ls-files", *HALLS], cwd=ROOT, capture_output=True, check=True)
    return [PurePosixPath(line) for line in listed.stdout.decode().splitlines()]


def entries() -> dict[str, set[str]]:
    """What lies in each folder, by its path."""
    found: dict[str, set[str]] = defaultdict(set)
    for path in files():
        for part in (path, *path.parents):
            if len(part.parts) > 1:
                found[str(part.parent)].add(part.name)
    return found


def test_no_folder_has_more_than_one_can_look_over() -> None:
    counts = {folder: len(names) for folder, names in entries().items()}
    halls = {*HALLS, *(f"tests/{PurePosixPath(hall).name}" for hall in HALLS)}
    assert counts["engine"] > 10, "the tree was read"
    assert {
        folder: count
        for folder, count in counts.items()
        if count > (CHAPTERS if folder in halls else ENTRIES)
    } == {}


@pytest.mark.parametrize("hall", ["engine", "app", "benchmarks"])
def test_no_file_of_the_product_is_long(hall: str) -> None:
    code = [path for path in files() if path.suffix == ".py" and str(path).startswith(hall)]
    assert code
    assert [
        str(path)
        for path in code
        if len((ROOT / path).read_text(encoding="utf-8").splitlines()) > LINES
    ] == []
