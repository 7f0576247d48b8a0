"""The jobs of workers: functions that take values and return bytes and small values.

A large result leaves the worker as the bytes of the response, because converting it again would
block the event loop.
"""

import time
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.app.computing import prices
from plinko.app.errors import InvalidValueError
from plinko.app.rooms.log import verify_log
from plinko.engine import (
    PHYSICS_VERSION,
    Board,
    Drop,
    DropBatch,
    concat,
    drop_many,
    json_text,
    verify,
)
from plinko.engine.batches.block import Block, summed
from plinko.engine.batches.job import Job
from plinko.engine.batches.tally import Tally
from plinko.engine.drops.digest import BLOCK
from plinko.engine.drops.drop import make_drop
from plinko.engine.drops.start import unsigned_zero
from plinko.engine.errors import shorten
from plinko.engine.json_text import Json, JsonObject
from plinko.engine.parameters import Exact, Solver, Stepped
from plinko.engine.payouts.solve import solve_payouts
from plinko.engine.seeding import SEED_LIMIT

if TYPE_CHECKING:
    from plinko.engine.certified.certify import Effort

MAX_SECONDS: Final = 9.0
"""CPU seconds for many drops. The error at this limit says how many were done; any other job runs
until `pool.DEADLINE`."""

MAX_FRAMES: Final = 100_000  # rows of one reply, about 10 MB of JSON

PROOF_SECONDS: Final = 8.0
"""CPU seconds for all proofs of a job; the rest stays undecided. Well below `pool.DEADLINE`."""

_CHUNK: Final = 100  # drops between two checks of the time: a few ms on any preset


class Ask(NamedTuple):
    """All inputs of a drop."""

    board: Board
    seed: int
    x: float | None
    solver: Solver
    aim: float | None = None

    @property
    def name(self) -> str:
        """A unique name of the drop, known before the drop is computed."""
        how = self.solver.encoded().hex()
        return f"{PHYSICS_VERSION}.{self.board.digest}.{self.seed}.{self.x!r}.{self.aim!r}.{how}"

    def drop(self) -> Drop:
        """Compute the drop.

        Raises ParameterError if the start is invalid, CostError if the path is too long.
        """
        if isinstance(self.solver, Stepped):
            # Compute it first without its path, which might not fit into memory.
            starts = None if self.x is None else [self.x]
            how: JsonObject = {"solver": "stepped", "threads": 1, **self.solver.fields()}
            found = drop_many(self.board, [self.seed], xs=starts, aim=self.aim, **how)
            prices.stepped_drop(float(found.duration[0]) / self.solver.h).check()
        return make_drop(self.board, self.seed, unsigned_zero(self.x), self.solver, self.aim)


class Many(NamedTuple):
    """`drops` drops of a board with the exact solver, with consecutive seeds from `first` on."""

    board: Board
    drops: int
    first: int

    @property
    def seeds(self) -> range:
        return range(self.first, self.first + self.drops)


def frame_count(ask: Ask, fmt: str, fps: int) -> int:
    from plinko.app.render.animation import frame_count  # noqa: PLC0415

    return frame_count(ask.drop(), fmt, fps)


def record(ask: Ask, certainty: bool) -> tuple[str, bytes]:
    """A drop's digest, and its record as JSON."""
    found = ask.drop().to_dict(certainty=certainty)
    return found["digest"], msgspec.json.encode(found)


def proof_effort() -> "Effort":
    """The limit of one proof, common to server and command line, so that their answers agree."""
    from plinko.engine.certified.certify import Effort  # noqa: PLC0415 - may not be installed

    return Effort(seconds=PROOF_SECONDS, clock=time.process_time)


def proof(ask: Ask, certainty: bool) -> tuple[str, bytes]:
    """A drop's digest, and its record with a certificate, which proves as much as possible."""
    from plinko.engine.certified.certify import certify  # noqa: PLC0415

    found = certify(ask.board, ask.seed, x=ask.x, aim=ask.aim, effort=proof_effort())
    certificate = found.to_dict() | {"events": found.event_rows()}
    record = ask.drop().to_dict(certainty=certainty)
    return record["digest"], msgspec.json.encode(record | {"certificate": certificate})


def verdict(claimed: dict[str, object]) -> bytes:
    """Whether every bit of a drop's record is reproduced, as JSON."""
    return msgspec.json.encode(verify(claimed))


def log_verdict(log: dict[str, object]) -> bytes:
    """Whether a room's log is reproduced, as JSON.

    Raises InvalidValueError if this takes longer than MAX_SECONDS.
    """
    started = time.process_time()

    def check(tick: int) -> None:
        if time.process_time() - started > MAX_SECONDS:
            raise InvalidValueError(
                f"the log takes too long: {tick} ticks were replayed after {MAX_SECONDS:g} s; "
                "use plinko verify, which has no limit",
                field="tick",
            )

    return msgspec.json.encode(verify_log(log, check))


def check_json(text: bytes) -> None:
    """Raise JsonSyntaxError or JsonValueError if the body is not strict JSON."""
    json_text.parse(text)


def board_of(text: bytes) -> Board:
    """Parse a board.

    Raises BoardError if it cannot be played, JsonSyntaxError, JsonValueError, and
    InvalidValueError if it is not a JSON object. A worker parses it because a thread of the server
    would hold the GIL: with five thousand pegs the event loop would wait.
    """
    form = json_text.parse(text)
    if not isinstance(form, dict):
        raise InvalidValueError(f"a board is a JSON object, not {shorten(form)}", field="body")
    return Board.from_json(form)


def board_view(text: bytes) -> bytes:
    """A board's name, digest and complete form as JSON; raises like `board_of`."""
    return board_and_view(text)[1]


def board_and_view(text: bytes) -> tuple[Board, bytes]:
    """A board with its `board_view`; raises like `board_of`."""
    board = board_of(text)
    view = {"name": board.name, "digest": board.digest, "board": board.to_dict()}
    return board, msgspec.json.encode(view)


def frames(ask: Ask, fps: float) -> bytes:
    """The states at `fps` and at the landing as JSON; raises InvalidValueError if too many."""
    done = ask.drop()
    count = int(done.duration * fps) + 1
    if count > MAX_FRAMES:
        raise InvalidValueError(
            f"fps {fps:g} makes {count} frames of a drop of {done.duration:g} s; "
            f"at most {MAX_FRAMES} are allowed",
            field="fps",
        )
    times = np.arange(count) / fps
    if times[-1] < done.duration:
        times = np.append(times, done.duration)
    states = done.states(times)
    return msgspec.json.encode(
        {
            "board_digest": done.board.digest,
            "digest": done.digest,
            "fps": fps,
            "duration": done.duration,
            "fields": list(states.dtype.names or ()),
            "frames": states.tolist(),
            "before": _before(done).tolist(),
        }
    )


def _before(done: Drop) -> npt.NDArray[np.void]:
    """The state right before each impact, shape (n,), dtype STATE, in the impacts' order.

    That is the state at the last float64 before its time. Of two impacts at the same time, the
    second one has the state after the first.
    """
    impacts = done.impacts
    rows = done.states(np.nextafter(impacts["t"], 0.0))
    for i in range(1, len(impacts)):
        if impacts["t"][i] == impacts["t"][i - 1]:
            for name in ("t", "x", "y", "vx", "vy", "omega"):
                rows[name][i] = impacts[name][i - 1]
    return rows


class Patience:
    """Called with the number of drops done; raises InvalidValueError after too many CPU seconds."""

    def __init__(self, drops: int) -> None:
        self._drops = drops
        self._started = time.process_time()

    def __call__(self, done: int) -> None:
        if done < self._drops and time.process_time() - self._started > MAX_SECONDS:
            raise InvalidValueError(
                f"drops {self._drops} take too long on this board: {done} were done after "
                f"{MAX_SECONDS:g} s; use the command line, which has no limit",
                field="drops",
            )


def tally(board: Board, first: int, drops: int, solver: Solver) -> JsonObject:
    """The summary of many drops; raises InvalidValueError if they take longer than MAX_SECONDS."""
    found = Tally(Job(board, solver, first, drops))
    patience = Patience(drops)
    for number in range(found.job.blocks):
        found.add(_block(found.job, number, patience))
    return found.summary()


def seeds_in(
    board: Board,
    bin_: int,
    first: int,
    count: int,
    drops: int,
    aim: float | None,
) -> JsonObject:
    """Find the next `count` seeds from `first` on that land in a bin, with at most `drops` drops.

    Raises InvalidValueError if they take longer than MAX_SECONDS.
    """
    patience, begin = Patience(drops), first
    found: list[int] = []
    last = min(first + drops, SEED_LIMIT) - 1
    while len(found) < count and begin <= last:
        seeds = range(begin, min(begin + _CHUNK, last + 1))
        batch = drop_many(board, seeds, aim=aim, threads=1)
        found += batch.seed[batch.bin == bin_].tolist()
        begin = seeds.stop
        patience(begin - first)
    if len(found) >= count:
        found = found[:count]
        last = found[-1]
    return {
        "board_digest": board.digest,
        "bin": bin_,
        "seeds": [str(seed) for seed in found],
        "last": str(last),
    }


def _block(job: Job, number: int, patience: Patience) -> Block:
    """Compute a block, checking the time after each chunk of drops."""
    seeds = job.seeds(number)
    parts: list[DropBatch] = []
    for begin in range(0, len(seeds), _CHUNK):
        part = seeds[begin : begin + _CHUNK]
        parts.append(drop_many(job.board, part, threads=1, **job.options))
        patience(number * BLOCK + begin + len(part))
    return summed(number, concat(parts))


def payouts(board: Board, returned: float, risk: str, drops: int) -> JsonObject:
    """Solve a payout table with at most `drops` drops from each aim."""
    return solve_payouts(board, returned=returned, risk=risk, drops=drops, threads=1).to_dict()


# The first picture imports Pillow where the fork server has not done so.


def still(ask: Ask, fmt: Json, width: int, theme: Json, at: float | None) -> bytes:
    """Draw a drop: its path, or the moment `at` s after the start."""
    from plinko.app.render import drop_picture  # noqa: PLC0415

    return drop_picture(ask.drop(), fmt, width, theme, at)


def animation(ask: Ask, fmt: Json, width: int, fps: int, theme: Json) -> bytes:
    from plinko.app.render import drop_animation  # noqa: PLC0415

    return drop_animation(ask.drop(), fmt, width, fps, theme)


def density(many: Many, fmt: Json, width: int, theme: Json) -> bytes:
    """Draw where the balls of many drops spend their time."""
    from plinko.app.render import density_picture  # noqa: PLC0415

    patience = Patience(many.drops)
    return density_picture(many.board, many.seeds, fmt, width, theme, 1, patience)


def histogram(many: Many, fmt: Json, width: int, theme: Json) -> bytes:
    from plinko.app.render import histogram_picture  # noqa: PLC0415

    found = tally(many.board, many.first, many.drops, Exact())
    landed, unsettled = found["histogram"], found["unsettled"]
    return histogram_picture(many.board, landed, fmt, width, theme, unsettled)


def sheet(many: Many, fmt: Json, width: int, theme: Json, columns: int | None) -> bytes:
    from plinko.app.render import contact_sheet  # noqa: PLC0415

    patience = Patience(many.drops)
    return contact_sheet(many.board, many.seeds, fmt, width, theme, columns, patience)
