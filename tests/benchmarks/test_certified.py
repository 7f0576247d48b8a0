"""The benchmark of proofs counts what the proofs say."""

from pathlib import Path

from PIL import Image

from benchmarks.accuracy import certified
from benchmarks.harness.effort import Effort
from plinko.engine import Board, certify


def test_shares_and_precisions_are_those_of_the_proofs(tmp_path: Path) -> None:
    section = certified.run(Effort(quick=True, rounds=1))
    right = section.data["right"]
    board = Board.preset(certified.BOARD)
    agreeing = sum(bool(certify(board, seed).agrees) for seed in range(right["drops"]))
    assert (right["right"], right["undecided"]) == (agreeing, 0)
    for name, points in section.data["precision"].items():
        proven = certify(Board.preset(name), 0)
        assert [point.impacts for point in points] == [proven.impacts]
        assert all(point.bits <= proven.bits for point in points)
    path = tmp_path / certified.PLOT
    section.plots[certified.PLOT](str(path))
    with Image.open(path) as picture:
        assert picture.width > 400
