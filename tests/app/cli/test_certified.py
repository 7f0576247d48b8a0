"""`plinko certify`, `plinko map` and `plinko simulate --certify`."""

from pathlib import Path

import pytest
from PIL import Image

from plinko.app.cli import common
from plinko.engine import Board, certify
from tests.app.cli.conftest import Terminal


def test_a_bin_is_printed_as_proven(plinko: Terminal) -> None:
    expected = certify(Board.preset("triangle-8"), 42)
    printed = plinko.run("certify", "triangle-8", "--seed", 42)
    assert expected.x_end is not None
    assert f"{expected.bin} of 0 to 8, proven" in printed
    assert expected.x_end.text in printed
    assert f"{expected.comparisons} comparisons decided with {expected.bits} bits" in printed
    value = plinko.json("certify", "triangle-8", "--seed", 42)
    assert value.items() >= expected.to_dict().items()
    assert (value["board"], value["seed"]) == ("triangle-8", "42")


def test_a_start_is_given_by_a_seed_or_exactly(plinko: Terminal) -> None:
    assert "x = 1/100 m" in plinko.run("certify", "triangle-8", "--x", "1/100")
    for args in ([], ["--seed", 1, "--x", 0]):
        assert "give a start" in plinko.refuses("certify", "triangle-8", *args)


def test_the_share_of_right_bins_is_printed(plinko: Terminal) -> None:
    asked = ("simulate", "triangle-8", "--drops", 3, "--certify")
    share = plinko.json(*asked)["certified"]
    assert share["certain"] + share["proven"] + share["undecided"] == 3
    assert f"{share['share_right']:.2%} of the bins in double precision" in plinko.run(*asked)
    assert "--certify needs --solver exact" in plinko.refuses(*asked, "--solver", "stepped")


def test_the_map_is_drawn_into_a_file(plinko: Terminal, tmp_path: Path) -> None:
    out = tmp_path / "map.png"
    small = ("--levels", 2, "--pixels", 2, "--x", "1/100")
    assert "proofs" in plinko.run("map", "triangle-8", out, *small)
    with Image.open(out) as picture:
        assert picture.width >= 98
    assert "must end in one of .png" in plinko.refuses("map", "triangle-8", "map.txt")
    assert "there is no folder" in plinko.refuses("map", "triangle-8", tmp_path / "none" / "a.png")


def test_without_the_library_the_error_says_what_to_install(
    plinko: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(common, "find_spec", lambda name: None)
    said = plinko.refuses("certify", "triangle-8", "--seed", 42)
    assert "pip install 'plinko-sim[certify]'" in said
