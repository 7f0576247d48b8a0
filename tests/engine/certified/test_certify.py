"""The claims of a certificate; a wrong law or a tie must not pass as a proof."""

from fractions import Fraction
from typing import Any

import pytest
from flint import arb

from plinko.engine import Board, ParameterError, SeedError, certify, drop
from plinko.engine.board.parts import Bins, Peg, Wall
from plinko.engine.certified import flight, impulse, spread, trace
from plinko.engine.certified.balls import ZERO, Proof, UndecidedError, precision
from plinko.engine.certified.certify import Effort, prove
from plinko.engine.certified.contact import series as contact_series
from plinko.engine.certified.contact import spread as contact_spread
from plinko.engine.certified.many import certify_many
from plinko.engine.certified.surfaces import Pair
from plinko.engine.drops.start import start_of
from tests.long import tries
from tools.oracle import golden
from tools.oracle.random_scenes import random_scene
from tools.oracle.scenes import scene

TRIANGLE = Board.preset("triangle-8")


def test_a_seed_gives_a_theorem_that_more_bits_do_not_change() -> None:
    few, many = (certify(TRIANGLE, 42, effort=Effort(bits, 4096)) for bits in (160, 640))
    assert few.decided
    assert (few.bin, few.impacts, few.agrees) == (many.bin, many.impacts, True)
    assert few.bin == drop(TRIANGLE, 42).bin
    for name in ("x_end", "duration"):
        narrow, wide = getattr(many, name), getattr(few, name)
        assert wide.low <= narrow.low <= narrow.high <= wide.high
    assert few.comparisons > 100


def test_precision_is_doubled_until_all_is_decided() -> None:
    found = certify(TRIANGLE, 42, effort=Effort(first_bits=30, most_bits=960))
    assert found.decided
    assert found.bits in (60, 120, 240, 480, 960)
    starved = certify(TRIANGLE, 42, effort=Effort(first_bits=30, most_bits=30))
    assert (starved.decided, starved.bin, starved.x_end, starved.agrees) == (False,) + (None,) * 3
    assert starved.undecided


def test_a_start_is_taken_to_all_its_digits() -> None:
    """Two starts that are equal in float64 have provably different landings."""
    near = certify(TRIANGLE, x="0.01", effort=Effort(400))
    far = certify(TRIANGLE, x=Fraction(1, 100) + Fraction(1, 10**40), effort=Effort(400))
    assert near.path is not None
    assert far.path is not None
    with precision(400):
        gap = far.path.events[-1].state.x - near.path.events[-1].state.x
        assert 0 < abs(gap) < arb("1e-15")
    assert near.x_start == "1/100"


def test_a_proof_of_a_wide_start_holds_for_all_starts_in_it() -> None:
    middle, radius = Fraction(1, 100), Fraction(1, 10**60)
    wide = prove(TRIANGLE, middle, radius, Effort(320, 320))
    assert wide.path is not None
    for share in (-1, 1):
        inside = prove(TRIANGLE, middle + share * radius, effort=Effort(448))
        assert inside.path is not None
        assert inside.path.bin == wide.path.bin
        for event, around in zip(inside.path.events, wide.path.events, strict=True):
            assert around.state.x.contains(event.state.x)
            assert around.state.vy.contains(event.state.vy)
    assert prove(TRIANGLE, middle, Fraction(1, 100), Effort(160, 160)).path is None


@pytest.mark.parametrize(("seed", "digits"), [(4, 12), (3, 24)])
def test_a_wide_start_is_followed_by_how_fast_its_paths_part(seed: int, digits: int) -> None:
    """Boxes without derivatives prove fewer starts at once; with seed 3 the ball also rolls."""
    middle, radius = Fraction(start_of(TRIANGLE, seed, None)), Fraction(1, 10**digits)
    wide = prove(TRIANGLE, middle, radius, Effort(160, 160))
    assert wide.path is not None
    assert wide.path.bin == certify(TRIANGLE, seed).bin
    with precision(160), pytest.raises(UndecidedError):
        trace.trace(TRIANGLE, arb(float(middle)) + arb(0, float(radius)), 160, Proof())
    for share in (-1, Fraction(1, 3), 1):
        inside = prove(TRIANGLE, middle + share * radius, effort=Effort(448))
        assert inside.path is not None
        for event, around in zip(inside.path.events, wide.path.events, strict=True):
            for name in ("t", "x", "y", "vx", "vy", "omega"):
                assert getattr(around.state, name).contains(getattr(event.state, name))


@pytest.mark.parametrize(
    ("module", "law", "seed", "digits"),
    [(spread, "_through_bounce", 4, 13), (contact_spread, "carried", 3, 26)],
)
def test_a_derivative_of_the_wrong_law_is_found_out(
    monkeypatch: pytest.MonkeyPatch, module: Any, law: str, seed: int, digits: int
) -> None:
    """If the derivative is too small, the proven region does not contain the true paths."""
    right = getattr(module, law)

    def wrong(*parts: Any) -> Any:
        after = right(*parts)
        return after._replace(way=after.way / 2, along=after.along / 2, omega=after.omega / 2)

    middle, radius = Fraction(start_of(TRIANGLE, seed, None)), Fraction(1, 10**digits)
    inside = prove(TRIANGLE, middle + radius, effort=Effort(448))
    assert inside.path is not None
    monkeypatch.setattr(module, law, wrong)
    try:
        wide = prove(TRIANGLE, middle, radius, Effort(160, 160))
    except ValueError:  # box and line are disjoint: the error is detected
        return
    assert wide.path is None or not all(
        around.state.x.contains(event.state.x)
        for event, around in zip(inside.path.events, wide.path.events, strict=False)
    )


def test_a_ball_in_perfect_balance_is_proven_to_rest() -> None:
    found = certify(Board.preset("triangle-16"), x=0)
    assert (found.decided, found.bin, found.unsettled) == (
        True,
        None,
        "balanced: at rest on a surface",
    )


def test_what_happens_at_once_by_symmetry_is_recognised_and_said() -> None:
    """With pegs at equal distances on both sides, the first in the board's order is hit first."""
    board = scene(pegs=(Peg(-0.14, 0.0, 0.05), Peg(0.14, 0.0, 0.05)), restitution=0.5)
    found = certify(board, x=0.0)
    assert found.ties[0] == "peg 0 and peg 1, by symmetry"
    lone = certify(board, x=2.0**-60)
    assert lone.decided
    assert lone.ties == ()


def test_a_landing_on_an_edge_belongs_to_the_bin_on_its_right() -> None:
    board = scene(bins=Bins(2.0, (-50.0, 0.25, 50.0), (1.0, 1.0)))
    assert certify(board, x=0.25).bin == 1
    assert certify(board, x=Fraction(1, 4) - Fraction(1, 10**50)).bin == 0


def test_a_graze_is_decided_however_narrow() -> None:
    """A ball falls past a peg at a distance 1e-30 m above or below the sum of the radii."""
    board = scene(pegs=(Peg(0.0, 0.0, 0.5),), radius=0.25, restitution=0.5)
    at = Fraction(3, 4)
    past = certify(board, x=at + Fraction(1, 10**30))
    hit = certify(board, x=at - Fraction(1, 10**30))
    assert (past.impacts, hit.impacts) == (0, 1)
    assert past.decided
    assert hit.decided


def test_bad_starts_are_named() -> None:
    with pytest.raises(SeedError, match="-1"):
        certify(TRIANGLE, -1)
    with pytest.raises(ParameterError, match="seed or an explicit x"):
        certify(TRIANGLE)
    with pytest.raises(ParameterError, match="x 'left' is not a finite number"):
        certify(TRIANGLE, x="left")
    with pytest.raises(ParameterError, match="x "):
        certify(TRIANGLE, x=1000)
    for text in ("1e999999999", "1/0", "nan", "inf", "1" * 401, "1/1e-999999"):
        with pytest.raises(ParameterError, match="is not a finite number"):
            certify(TRIANGLE, x=text)


@pytest.mark.long
def test_on_boards_thrown_together_proofs_and_certain_bins_agree() -> None:
    """Random pegs and walls of any size and slope; both solvers decide most drops."""
    decided = 0
    seeds = range(tries(6, 400))
    for seed in seeds:
        board, x = random_scene(seed)
        found = certify(board, x=x, effort=Effort(160, 320, 4000))
        if found.decided:
            decided += 1
            assert found.agrees or not drop(board, 0, x=x).certain, seed
    assert decided > 0.7 * len(seeds)


def test_the_share_of_right_bins_is_counted() -> None:
    seeds = range(6)
    share = certify_many(TRIANGLE, seeds, everything=True)
    proven = [certify(TRIANGLE, seed) for seed in seeds]
    assert (share.drops, share.proven, share.undecided) == (6, 6, 0)
    assert share.right == sum(bool(found.agrees) for found in proven)
    assert share.certain == sum(drop(TRIANGLE, seed).certain for seed in seeds)
    only = certify_many(TRIANGLE, seeds)
    assert only.proven == 6 - only.certain
    assert share.share_right == share.right / 6


# With a law that is wrong by a sign, a factor or a bound, proofs must disagree with the oracle.


def _traced(name: str, number: int) -> tuple[str, bool]:
    """The events of an oracle's drop by the certified solver, and whether it encloses the end."""
    head, drops = golden.load(name)
    asked = drops[number]
    with precision(160):
        try:
            board = Board.from_json(head["board"])
            path = trace.trace(board, arb(asked.x), 160, Proof())
        except UndecidedError:
            return "", False
        marks = " ".join(f"{e.kind}" if e.kind == 5 else f"{e.kind}:{e.index}" for e in path.events)
        return marks, bool(path.events[-1].state.x.overlaps(arb(asked.x_end)))


def _agrees(name: str, number: int) -> bool:
    marks, enclosed = _traced(name, number)
    return enclosed and marks == golden.load(name)[1][number].turns


def test_the_right_laws_agree() -> None:
    assert _agrees("triangle-16", 0)
    assert _agrees("trial-12", 1)


def _other_sign(
    approach: arb, along: arb, omega: arb, pair: Pair, radius: arb, proof: Proof
) -> impulse.Rebound:
    return impulse.bounce(approach, along, -omega, pair, radius, proof)


def _pushing(self: flight.Flight, s: arb, right: Any = flight.Flight.basis) -> tuple[arb, arb, arb]:
    decay, phi, psi = right(self, s)
    return 2 - decay, 2 * s - phi, s * s - psi


def _as_a_ring(
    self: contact_series.Stretch,
    terms: int,
    proof: Proof,
    right: Any = contact_series.Stretch._expand,
) -> list[list[arb]]:
    """The inertia of a ring (factor 1/2) instead of a disc (2/3)."""
    law = self.law
    self.law = law._replace(gravity=law.gravity * 3 / 4)
    try:
        found: list[list[arb]] = right(self, terms, proof)
        return found
    finally:
        self.law = law


@pytest.mark.parametrize(
    ("place", "name", "wrong"),
    [
        pytest.param(trace, "bounce", _other_sign, id="friction of the other sign"),
        pytest.param(flight.Flight, "basis", _pushing, id="drag of the other sign"),
        pytest.param(contact_series.Stretch, "_expand", _as_a_ring, id="another inertia"),
        pytest.param(
            contact_series,
            "square",
            lambda series, end: contact_series.Series([ZERO], ZERO),
            id="a normal force without its centripetal part",
        ),
    ],
)
def test_a_proof_by_a_wrong_law_does_not_agree(
    monkeypatch: pytest.MonkeyPatch, place: Any, name: str, wrong: Any
) -> None:
    monkeypatch.setattr(place, name, wrong)
    assert not _agrees("triangle-16", 0)


def test_a_ball_on_walls_and_ends_goes_where_doubles_say() -> None:
    """The ball goes down a ramp, over its end, and on."""
    board = scene(
        walls=(Wall(-0.5, 0.2, 0.3, 0.5), Wall(0.3, 0.5, 0.6, 0.8)),
        restitution=0.2,
        friction=0.4,
        drag=0.5,
    )
    found = certify(board, x=-0.3)
    assert found.decided
    asked = drop(board, 0, x=-0.3)
    assert found.path is not None
    marks = [(event.kind, event.index) for event in found.path.events]
    assert marks == [(int(e["kind"]), int(e["index"])) for e in asked.impacts]
    for event, row in zip(found.path.events, asked.impacts, strict=True):
        assert abs(float(event.state.x) - row["x"]) < 1e-9
        assert abs(float(event.state.omega) - row["omega"]) < 1e-6
