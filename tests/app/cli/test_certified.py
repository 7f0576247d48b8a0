"""`plinko certify`, `plinko map` and `plinko simulate --certify`."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from plinko.app.cli import common, main
from plinko.engine import Board, certify

Run = Callable[..., str]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run a command, check its exit code `status`, and return its output."""

    def command(*args: str, status: int = 0) -> str:
        assert main(list(args)) == status
        out, err = capsys.readouterr()
        return str(out + err)

    return command


def test_a_bin_is_printed_as_proven(run: Run) -> None:
    expected = certify(Board.preset("triangle-8"), 42)
    printed = run("certify", "triangle-8", "--seed", "42")
    assert expected.x_end is not None
    assert f"{expected.bin} of 0 to 8, proven" in printed
    assert expected.x_end.text in printed
    assert f"{expected.comparisons} comparisons decided with {expected.bits} bits" in printed
    value: dict[str, Any] = json.loads(run("certify", "triangle-8", "--seed", "42", "--json"))
    assert value.items() >= expected.to_dict().items()
    assert (value["board"], value["seed"]) == ("triangle-8", "42")


def test_a_start_is_given_by_a_seed_or_exactly(run: Run) -> None:
    assert "x = 1/100 m" in run("certify", "triangle-8", "--x", "1/100")
    for args in ([], ["--seed", "1", "--x", "0"]):
        assert "give a start" in run("certify", "triangle-8", *args, status=2)


def test_the_share_of_right_bins_is_printed(run: Run) -> None:
    value = json.loads(run("simulate", "triangle-8", "--drops", "3", "--certify", "--json"))
    share = value["certified"]
    assert share["certain"] + share["proven"] + share["undecided"] == 3
    shown = run("simulate", "triangle-8", "--drops", "3", "--certify")
    assert f"{share['share_right']:.2%} of the bins in double precision" in shown
    stepped = ["simulate", "triangle-8", "--drops", "3", "--certify", "--solver", "stepped"]
    assert "--certify needs --solver exact" in run(*stepped, status=2)


def test_the_map_is_drawn_into_a_file(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "map.png"
    args = ["triangle-8", str(out), "--levels", "2", "--pixels", "2", "--x", "1/100"]
    assert "proofs" in run("map", *args)
    with Image.open(out) as picture:
        assert picture.width >= 98
    assert "must end in one of .png" in run("map", "triangle-8", "map.txt", status=2)
    nowhere = str(tmp_path / "none" / "map.png")
    assert "there is no folder" in run("map", "triangle-8", nowhere, status=2)


def test_without_the_library_the_error_says_what_to_install(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(common, "find_spec", lambda name: None)
    said = run("certify", "triangle-8", "--seed", "42", status=2)
    assert "pip install 'plinko-sim[certify]'" in said
