"""What workers are asked for: functions of a module, values in, bytes and small values out.

What is large leaves a worker as the bytes that are sent: to take it apart once more would keep the
event loop.
"""

import time
from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from app.computing import prices
from app.errors import InvalidValueError, shorten
from app.rooms.log import verify_log
from engine import PHYSICS_VERSION, Board, Drop, DropBatch, drop_many, json_text, verify
from engine.batches.block import Block, summed
from engine.batches.job import Job
from engine.batches.tally import Tally
from engine.drops.digest import BLOCK
from engine.drops.drop import make_drop
from engine.drops.seeds import Search
from engine.drops.start import unsigned_zero
from engine.json_text import JsonObject
from engine.parameters import Exact, Solver, Stepped
from engine.payouts.solve import solve_payouts
from engine.seeding import SEED_LIMIT

MAX_SECONDS: Final = 9.0
"""s of a core for many drops, after which it is said how many were done; `pool.DEADLINE` ends the
rest."""

MAX_FRAMES: Final = 100_000  # rows of one reply, about 10 MB of JSON

_CHUNK: Final = 100  # drops between two looks at the clock: a few ms on any preset


@dataclass(frozen=True, slots=True)
class Ask:
    """Everything that decides a drop."""

    board: Board
    seed: int
    x: float | None
    solver: Solver
    aim: float | None = None

    @property
    def name(self) -> str:
        """What the drop is called before it is computed: no two drops have the same name."""
        how = self.solver.encoded().hex()
        return f"{PHYSICS_VERSION}.{self.board.digest}.{self.seed}.{self.x!r}.{self.aim!r}.{how}"

    def drop(self) -> Drop:
        """Compute it; raises ParameterError for a bad start, CostError for too long a path."""
        if isinstance(self.solver, Stepped):
            # Followed once without keeping the path, which may be more than there is memory for.
            starts = None if self.x is None else [self.x]
            how: JsonObject = {"solver": "stepped", "threads": 1, **self.solver.fields()}
            found = drop_many(self.board, [self.seed], xs=starts, aim=self.aim, **how)
            prices.stepped_drop(float(found.duration[0]) / self.solver.h).check()
        return make_drop(self.board, self.seed, unsigned_zero(self.x), self.solver, self.aim)


@dataclass(frozen=True, slots=True)
class Many:
    """Drops of a board with the exact solver: as many seeds from `first` on."""

    board: Board
    drops: int
    first: int

    @property
    def seeds(self) -> range:
        """All of them."""
        return range(self.first, self.first + self.drops)


def duration(ask: Ask) -> float:
    """How long a drop lasts, s."""
    return ask.drop().duration


def record(ask: Ask, certainty: bool) -> tuple[str, bytes]:
    """A drop's digest, and its record as JSON."""
    found = ask.drop().to_dict(certainty=certainty)
    return found["digest"], msgspec.json.encode(found)


def verdict(claimed: dict[str, object]) -> bytes:
    """As JSON whether every bit of a drop's record is reproduced."""
    found = verify(claimed)
    names = ("ok", "field", "expected", "actual")
    return msgspec.json.encode({name: getattr(found, name) for name in names})


def log_verdict(log: dict[str, object]) -> bytes:
    """As JSON whether a room's log is reproduced; raises InvalidValueError when that takes long."""
    started = time.process_time()

    def check(tick: int) -> None:
        if time.process_time() - started > MAX_SECONDS:
            raise InvalidValueError(
                f"the log takes too long: {tick} ticks were replayed after {MAX_SECONDS:g} s; "
                "plinko verify takes its time",
                field="tick",
            )

    found = verify_log(log, check)
    names = ("ok", "field", "expected", "actual")
    return msgspec.json.encode({name: getattr(found, name) for name in names})


def check_json(text: bytes) -> None:
    """Raise JsonSyntaxError or JsonValueError for a body that is not strict JSON."""
    json_text.parse(text)


def board_of(text: bytes) -> Board:
    """A board from its JSON.

    Raises BoardError when it cannot be played, JsonSyntaxError, JsonValueError, and
    InvalidValueError for what is no JSON object. It is read here: the event loop would wait for
    five thousand pegs that a thread of its own process reads, and for their pickling.
    """
    form = json_text.parse(text)
    if not isinstance(form, dict):
        raise InvalidValueError(f"a board is a JSON object, not {shorten(form)}", field="body")
    return Board.from_json(form)


def board_view(text: bytes) -> bytes:
    """A board's name, digest and whole form as JSON; raises what `board_of` raises."""
    return board_and_view(text)[1]


def board_and_view(text: bytes) -> tuple[Board, bytes]:
    """A board with its `board_view`; raises what `board_of` raises."""
    board = board_of(text)
    view = {"name": board.name, "digest": board.digest, "board": board.to_dict()}
    return board, msgspec.json.encode(view)


def frames(ask: Ask, fps: float) -> bytes:
    """The states at `fps` and at the landing as JSON; raises InvalidValueError for too many."""
    done = ask.drop()
    count = int(done.duration * fps) + 1
    if count > MAX_FRAMES:
        raise InvalidValueError(
            f"fps {fps:g} makes {count} frames of a drop of {done.duration:g} s; "
            f"at most {MAX_FRAMES}",
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

    That is the state at the last instant before it that has a float64, or, of two impacts at one
    instant, what the first made of it for the second.
    """
    impacts = done.impacts
    rows = done.states(np.nextafter(impacts["t"], 0.0))
    for i in range(1, len(impacts)):
        if impacts["t"][i] == impacts["t"][i - 1]:
            for name in ("t", "x", "y", "vx", "vy", "omega"):
                rows[name][i] = impacts[name][i - 1]
    return rows


class Patience:
    """Called with the drops done so far; raises InvalidValueError after so many `seconds`."""

    def __init__(self, drops: int, seconds: float) -> None:
        self._drops = drops
        self._seconds = seconds
        self._started = time.process_time()

    def __call__(self, done: int) -> None:
        """So many are done."""
        if done < self._drops and time.process_time() - self._started > self._seconds:
            raise InvalidValueError(
                f"drops {self._drops} take too long on this board: {done} were done after "
                f"{self._seconds:g} s; the command line takes its time",
                field="drops",
            )


def tally(
    board: Board, first: int, drops: int, solver: Solver, seconds: float = MAX_SECONDS
) -> JsonObject:
    """The summary of many drops; raises InvalidValueError when they take longer than `seconds`."""
    found = Tally(Job(board, solver, first, drops))
    patience = Patience(drops, seconds)
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
    seconds: float = MAX_SECONDS,
) -> JsonObject:
    """Seeds from `first` on that land in a bin, the next `count` among at most so many `drops`.

    Raises InvalidValueError when they take longer than `seconds`.
    """
    search, patience = Search(board, bin_, first, aim, 1), Patience(drops, seconds)
    found: list[int] = []
    last = min(first + drops, SEED_LIMIT) - 1
    while len(found) < count and search.next <= last:
        found += search.take(min(_CHUNK, last + 1 - search.next))
        patience(search.next - first)
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
    """A block, with a look at the clock after every few drops."""
    seeds = job.seeds(number)
    parts: list[DropBatch] = []
    for begin in range(0, len(seeds), _CHUNK):
        part = seeds[begin : begin + _CHUNK]
        parts.append(drop_many(job.board, part, threads=1, **job.options))
        patience(number * BLOCK + begin + len(part))
    return summed(number, parts)


def payouts(board: Board, returned: float, risk: str, drops: int) -> JsonObject:
    """A solved payout table by at most so many drops from each aim."""
    return solve_payouts(board, returned=returned, risk=risk, drops=drops, threads=1).to_dict()


# Pillow is loaded when the first picture is asked for, where it was not before.


def still(ask: Ask, fmt: str, width: int, theme: str, at: float | None) -> bytes:
    """A drop as a picture."""
    from app.render import drop_picture  # noqa: PLC0415

    return drop_picture(ask.drop(), fmt, width, theme, at)


def animation(ask: Ask, fmt: str, width: int, fps: int, theme: str) -> bytes:
    """A drop as it falls."""
    from app.render import drop_animation  # noqa: PLC0415

    return drop_animation(ask.drop(), fmt, width, fps, theme)


def density(many: Many, fmt: str, width: int, theme: str, seconds: float = MAX_SECONDS) -> bytes:
    """Where the balls of many drops are, as a picture."""
    from app.render import density_picture  # noqa: PLC0415

    patience = Patience(many.drops, seconds)
    return density_picture(many.board, many.seeds, fmt, width, theme, 1, patience)


def histogram(many: Many, fmt: str, width: int, theme: str) -> bytes:
    """How many balls land in each bin, as a picture."""
    from app.render import histogram_picture  # noqa: PLC0415

    found = tally(many.board, many.first, many.drops, Exact())
    landed, unsettled = found["histogram"], found["unsettled"]
    return histogram_picture(many.board, landed, fmt, width, theme, unsettled)


def sheet(
    many: Many,
    fmt: str,
    width: int,
    theme: str,
    columns: int | None,
    seconds: float = MAX_SECONDS,
) -> bytes:
    """The whole paths of many drops side by side, as a picture."""
    from app.render import contact_sheet  # noqa: PLC0415

    patience = Patience(many.drops, seconds)
    return contact_sheet(many.board, many.seeds, fmt, width, theme, columns, patience)
