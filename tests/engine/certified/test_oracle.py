"""The certified solver's proofs agree with the fifty-digit oracle in every digit."""

import pytest
from flint import arb

from plinko.engine.board.model import Board
from plinko.engine.certified.balls import precision
from plinko.engine.certified.certify import Certificate, certify
from tests.long import tries
from tools.oracle import golden
from tools.oracle.golden import GoldenDrop

BOARDS = ("plain-12", "trial-8", "trial-16", "triangle-8", "triangle-12", "triangle-16")


def encloses(ball: arb, decimal: str) -> bool:
    """Whether an enclosure can contain a number of 25 digits, whose last digit is rounded."""
    digits = decimal.split("e", maxsplit=1)[0].lstrip("-").replace(".", "").lstrip("0")
    with precision(400):
        number = arb(decimal)
        rounding = abs(number) * arb(10) ** (1 - len(digits))
        return bool((number + arb(0, rounding.abs_upper())).overlaps(ball))


def turns_of(certificate: Certificate) -> str:
    """Kind and index of each event, in the format of the oracle's files."""
    assert certificate.path is not None
    marks = ((event.kind, event.index) for event in certificate.path.events)
    return " ".join(f"{kind}" if kind == 5 else f"{kind}:{index}" for kind, index in marks)


def assert_same(certificate: Certificate, drop: GoldenDrop) -> None:
    path = certificate.path
    assert path is not None
    assert turns_of(certificate) == drop.turns
    assert certificate.bin == drop.bin
    last = path.events[-1].state
    assert encloses(last.x, drop.x_end)
    assert encloses(last.t, drop.duration)
    for event, row in zip(path.events, drop.events, strict=False):
        s = event.state
        for ball, decimal in zip((s.t, s.x, s.y, s.vx, s.vy, s.omega), row, strict=True):
            assert encloses(ball, decimal)


@pytest.mark.long
@pytest.mark.parametrize("name", BOARDS)
def test_what_is_proven_is_what_the_oracle_says(name: str) -> None:
    head, drops = golden.load(name)
    board = Board.from_json(head["board"])
    for drop in drops[: tries(1, None)]:
        certificate = certify(board, x=drop.x)
        assert certificate.decided
        assert_same(certificate, drop)
