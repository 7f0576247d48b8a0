"""Many drops, computed on all cores. The outcome of each depends only on its own start."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from operator import index as as_index
from typing import Any, Final, Never, TypeVar, overload

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import MAX_TIME
from plinko.engine.drops.digest import outcomes_digest
from plinko.engine.drops.drawing import histogram_svg
from plinko.engine.drops.drop import Drop, make_drop
from plinko.engine.drops.start import aim_of, start_of
from plinko.engine.drops.threads import share, thread_count
from plinko.engine.errors import MissingPartError, ParameterError, SeedError
from plinko.engine.exact.board_arrays import BoardArrays, arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.initial_state import at_rest
from plinko.engine.exact.lanes import trial
from plinko.engine.exact.lanes.trace import Code, Drops, trace_drops
from plinko.engine.exact.outcome import LANDED, MAX_EVENTS, REASONS, Results, new_results
from plinko.engine.notebooks import figure, png
from plinko.engine.parameters import Solver, SolverName, Stepped, make_solver
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats
from plinko.engine.seeding import SEED_LIMIT, parse_seed, start_xs
from plinko.engine.stepped.step import trace_stepped_many

Seeds = int | Iterable[int | str] | npt.NDArray[np.integer[Any]]
"""Either a number of drops or the seeds themselves."""

MOST_DROPS: Final = 1 << 32
"""Limit of one call, whose outcomes must fit into memory. For more, see docs/batches.md."""

CHUNK = 4096
"""Most drops in a chunk, which is the work between two calls of `progress`: 10 to 60 ms."""

LEAST_CHUNK = 256
"""Fewest drops in a chunk; with fewer, Python's own overhead would show."""

WORTH_A_TRIAL: Final = 10_000
"""Fewest drops for which native code is used. A smaller batch takes less time than its trial."""

PARTS = 2
"""A chunk has at most 1/PARTS of the drops that remain per thread, so that all threads finish at
about the same time."""

_OF_ALL = ("board", "solver", "explicit_x", "aim")
"""Fields of a batch that are the same for all its drops."""


@dataclass(frozen=True, eq=False, repr=False)
class DropBatch:
    """Outcomes of many drops in the order of their seeds; all arrays have shape (n,), read-only.

    bin (-1 if the ball did not land), duration in s, impact_count, x_end in m, outcome
    (`plinko.engine.exact.outcome`), x_start in m. `batch[3]`, and each item of a loop over the
    batch, is a whole `Drop`, recomputed from its start. `batch[3:7]`, `batch[batch.bin == 3]` and
    `batch[[5, 2]]` are batches. Batches are equal if their digests are. polars, pyarrow and other
    readers of Arrow take a batch itself as a table; pandas takes its `columns()`.
    """

    board: Board
    solver: Solver
    seed: npt.NDArray[np.uint64]
    explicit_x: bool
    x_start: Floats
    bin: npt.NDArray[np.int32]
    duration: Floats
    impact_count: npt.NDArray[np.int32]
    x_end: Floats
    outcome: npt.NDArray[np.int8]
    aim: float | None = None

    def __len__(self) -> int:
        return len(self.bin)

    @overload
    def __getitem__(self, which: int | np.integer[Any]) -> Drop: ...

    @overload
    def __getitem__(self, which: slice | Sequence[int] | npt.NDArray[Any]) -> "DropBatch": ...

    def __getitem__(
        self, which: int | np.integer[Any] | slice | Sequence[int] | npt.NDArray[Any]
    ) -> "Drop | DropBatch":
        if isinstance(which, slice):
            return replace(self, **{name: array[which] for name, array in self._arrays().items()})
        try:
            row = as_index(which)  # type: ignore[arg-type]
        except TypeError:  # an array, or a list
            return self._rows(np.asarray(which))
        if not -len(self) <= row < len(self):
            raise IndexError(f"drop {row} is out of range: the batch has {len(self)} drops")
        x = float(self.x_start[row]) if self.explicit_x else None
        return make_drop(self.board, int(self.seed[row]), x, self.solver, self.aim)

    def _rows(self, which: npt.NDArray[Any]) -> "DropBatch":
        """The drops of a boolean mask, or at integers, as a batch."""
        rows = which if which.size else which.astype(np.intp)
        if rows.ndim != 1 or rows.dtype.kind not in "biu":
            raise IndexError(
                f"a batch has no drops at {which!r:.60}: use an integer, a slice, a boolean mask "
                "or an array of integers"
            )
        if rows.dtype.kind == "b" and len(rows) != len(self):
            raise IndexError(f"the mask has {len(rows)} values: the batch has {len(self)} drops")
        return replace(
            self, **{name: _read_only(array[rows]) for name, array in self._arrays().items()}
        )

    def _arrays(self) -> dict[str, Any]:
        names = (field.name for field in fields(self) if field.name not in _OF_ALL)
        return {name: getattr(self, name) for name in names}

    def __iter__(self) -> Iterator[Drop]:
        return (self[row] for row in range(len(self)))

    def __array__(self, *_: object, **__: object) -> Never:
        # pandas.DataFrame(batch) comes here too. It would otherwise recompute and copy every drop.
        raise TypeError("a batch has several columns: use one, such as batch.score, or columns()")

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def __eq__(self, other: object) -> bool:
        return self.digest == other.digest if isinstance(other, DropBatch) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        mean = f"{self.score.mean():.4g}" if len(self) else "none"
        return (
            f"<DropBatch of {len(self):,} on {self.board.name!r}: mean score {mean}, "
            f"{self.unsettled_count} unsettled, digest {self.digest[:12]}>"
        )

    def _repr_html_(self) -> str:
        return figure(histogram_svg(self.histogram.tolist()), repr(self))

    def _repr_png_(self) -> bytes | None:
        return png(self)

    def columns(self) -> dict[str, npt.NDArray[np.generic]]:
        """Columns by name, each of shape (n,): `pandas.DataFrame(batch.columns())`.

        seed, x_start (m), bin (-1 if the ball did not land), score, duration (s), impact_count,
        x_end (m), landed (bool).
        """
        return {
            "seed": self.seed,
            "x_start": self.x_start,
            "bin": self.bin,
            "score": self.score,
            "duration": self.duration,
            "impact_count": self.impact_count,
            "x_end": self.x_end,
            "landed": _read_only(self.outcome == LANDED),
        }

    def to_arrow(self) -> Any:
        """The columns as a `pyarrow.Table`; MissingPartError without pyarrow."""
        try:
            import pyarrow  # noqa: PLC0415 - takes half a second, and may not be installed
        except ImportError:
            raise MissingPartError(
                "Arrow needs pyarrow, which is not installed: pip install 'plinko-sim[table]', "
                "or use columns()"
            ) from None
        return pyarrow.table(self.columns())

    @property
    def unsettled(self) -> npt.NDArray[np.object_]:
        """Why each ball did not land, or None if it did, as in a `Drop`."""
        reasons: list[str | None] = [*REASONS]
        reasons[LANDED] = None
        return _read_only(np.array(reasons, object)[self.outcome])

    @property
    def unsettled_count(self) -> int:
        """Number of balls that did not land."""
        return int(np.count_nonzero(self.outcome != LANDED))

    @property
    def histogram(self) -> npt.NDArray[np.int64]:
        """Number of balls in each bin, shape (bins,)."""
        landed = self.bin[self.bin >= 0]
        counts = np.bincount(landed, minlength=self.board.bins.count)
        return _read_only(counts.astype(np.int64))

    @property
    def score(self) -> Floats:
        """Multiplier of each drop; 1, the stake back, if the ball did not land."""
        bins = self.board.bins
        table = np.array([bins.score_of(number) for number in (*range(bins.count), None)])
        return _read_only(table[self.bin])

    @cached_property
    def digest(self) -> str:
        """Merkle root over blocks of all outcomes, 64 hex digits.

        `plinko.engine.drops.digest` lists its bytes.
        """
        return outcomes_digest(
            self.board.digest, self.solver, self.bin, self.duration, self.impact_count, self.x_end
        )

    @cached_property
    def digests(self) -> tuple[str, ...]:
        """Digest of each drop, as `drop(board, seed).digest`; recomputes every drop."""
        return tuple(drop.digest for drop in self)


Array = TypeVar("Array", bound=npt.NDArray[Any])


def _read_only(array: Array) -> Array:
    array.setflags(write=False)
    return array


def drop_many(
    board: Board | str,
    seeds: Seeds | None = None,
    *,
    xs: npt.ArrayLike | None = None,
    aim: float | None = None,
    solver: SolverName = "exact",
    dt: float | None = None,
    substeps: int | None = None,
    correction: float | None = None,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> DropBatch:
    """Drop a ball for each of `seeds`, or from explicit starts `xs`, shape (n,), in m.

    board: a Board, or a preset's name.
    seeds: a number of drops n, for the seeds 0 to n - 1, or an iterable of seeds, shape (n,). With
    explicit starts they only number the drops, and may be left out.
    aim: the middle in m of the starts that the seeds draw (default: the board's own).
    threads: default is one per core that this process may use. The result does not depend on it.
    progress: called now and then with the number of drops done.

    Raises BoardError, SeedError or ParameterError naming the bad value.
    """
    board = Board.named(board)
    chosen = make_solver(solver, dt, substeps, correction)
    if xs is not None and aim is not None:
        raise ParameterError(f"aim is {aim!r}, but xs are given too: use only one", field="aim")
    starts = None if xs is None else _explicit_starts(board, xs)
    if seeds is None and starts is not None:
        seeds = len(starts)
    numbers = seed_array(seeds)
    count = len(numbers)
    if starts is None:
        starts = np.empty(count)
    elif len(starts) != count:
        raise ParameterError(
            f"xs has shape {starts.shape} for {count} seeds: it must be ({count},)", field="xs"
        )
    results = new_results(count)
    batch = DropBatch(
        board=board,
        solver=chosen,
        seed=numbers,
        explicit_x=xs is not None,
        x_start=starts,
        bin=results.bins,
        duration=results.durations,
        impact_count=results.impacts,
        x_end=results.x_ends,
        outcome=results.outcomes,
        aim=None if aim is None else aim_of(board, aim),
    )
    _fill(batch, results, thread_count(threads), progress)
    for array in batch._arrays().values():
        _read_only(array)
    return batch


def concat(batches: Iterable[DropBatch]) -> DropBatch:
    """Join batches on the same board, with the same solver and kind of start, in their order.

    Raises ParameterError if they differ, or if there is none.
    """
    parts = list(batches)
    if not parts:
        raise ParameterError("batches is empty: there must be at least one", field="batches")
    for number, part in enumerate(parts):
        for name in _OF_ALL:
            one, other = getattr(parts[0], name), getattr(part, name)
            if one != other:
                raise ParameterError(
                    f"batches[{number}] has {name} {other!r:.80}: it must be that of batches[0], "
                    f"{one!r:.80}",
                    field=f"batches[{number}]",
                )
    columns: dict[str, Any] = {
        name: _read_only(np.concatenate([getattr(part, name) for part in parts]))
        for name in parts[0]._arrays()
    }
    return replace(parts[0], **columns)


def seed_array(seeds: Seeds | None) -> npt.NDArray[np.uint64]:
    """Return `seeds` as uint64, shape (n,); SeedError names the first invalid seed.

    A number n stands for the seeds 0 to n - 1.
    """
    if isinstance(seeds, int | np.integer) and not isinstance(seeds, bool):
        if not 0 <= seeds < MOST_DROPS:
            raise SeedError(
                f"seeds is {seeds}: a number of drops must be from 0 to {MOST_DROPS - 1}",
                field="seeds",
            )
        seeds = range(int(seeds))
    if isinstance(seeds, range) and seeds and _are_seeds(seeds[0], seeds[-1]):
        offsets = np.arange(len(seeds), dtype=np.uint64) * np.uint64(seeds.step % SEED_LIMIT)
        return np.uint64(seeds.start) + offsets
    if isinstance(seeds, str) or not isinstance(seeds, Iterable):
        raise SeedError(
            f"seeds is {seeds!r}: it must be a number of drops, or seeds in a range, list or array",
            field="seeds",
        )
    listed = seeds if isinstance(seeds, np.ndarray) else list(seeds)
    given = np.asarray(listed)
    if given.ndim != 1:
        raise SeedError(f"seeds has {given.ndim} dimensions: it must have one", field="seeds")
    if given.dtype.kind == "u" or (given.dtype.kind == "i" and (given >= 0).all()):
        return given.astype(np.uint64)
    return np.array([parse_seed(seed) for seed in listed], np.uint64)


def _are_seeds(first: int, last: int) -> bool:
    """Whether all integers between `first` and `last`, in either order, are valid seeds."""
    return min(first, last) >= 0 and max(first, last) < SEED_LIMIT


def _explicit_starts(board: Board, xs: npt.ArrayLike) -> Floats:
    try:
        starts = np.asarray(xs, np.float64) + 0.0  # a copy, in which a negative zero is zero
    except (TypeError, ValueError) as error:
        raise ParameterError(f"xs {xs!r:.60} are not numbers: {error}", field="xs") from None
    if starts.ndim != 1:
        raise ParameterError(
            f"xs has {starts.ndim} dimensions: it must have one, as [0.1, 0.2] has", field="xs"
        )
    for x in starts[[starts.argmin(), starts.argmax()]] if len(starts) else ():
        start_of(board, None, float(x))  # also finds a NaN, which argmin prefers to any number
    return starts


def _fill(
    batch: DropBatch, results: Results, threads: int, progress: Callable[[int], None] | None
) -> None:
    """Compute all chunks in threads; the kernels release the GIL."""
    arrays = arrays_of(batch.board)
    code = trial.trusted() if len(batch) >= WORTH_A_TRIAL else trial.NONE
    share(
        _parts(len(batch), threads),
        lambda part, _: _run_part(batch, arrays, part, results, code),
        threads,
        progress,
    )


def _parts(count: int, threads: int) -> list[slice]:
    """Divide `count` drops into chunks, which get smaller towards the end."""
    parts = []
    first = 0
    while first < count:
        size = min(CHUNK, max(LEAST_CHUNK, (count - first) // (PARTS * threads)))
        parts.append(slice(first, min(first + size, count)))
        first += size
    return parts


def _run_part(
    batch: DropBatch,
    arrays: BoardArrays,
    part: slice,
    results: Results,
    code: Mapping[str, Code],
) -> int:
    """Write the outcomes of the drops in `part` to the batch's arrays; return their number."""
    zone = batch.board.drop
    if not batch.explicit_x:
        middle = zone.x if batch.aim is None else batch.aim
        batch.x_start[part] = start_xs(batch.seed[part], middle, zone.jitter)
    xs = batch.x_start[part]
    y = zone.y
    some = results.at(part)
    if isinstance(batch.solver, Stepped):
        _step(arrays, batch.solver, at_rest(xs, y), some)
    else:
        trace_drops(arrays, Drops(xs, y, MAX_EVENTS, MAX_TIME), some, code)
    return len(xs)


def _step(arrays: BoardArrays, solver: Stepped, states: Floats, results: Results) -> None:
    """Compute the drops that start in `states` with the stepped solver, one after the other."""
    bins, durations, x_ends, impacts, outcomes = results
    trace_stepped_many(
        arrays, states, solver.h, solver.correction, MAX_EVENTS, new_log(0, 0), outcomes, bins,
        impacts,
    )  # fmt: skip
    durations[:] = states[:, body.T]
    x_ends[:] = states[:, body.X]
