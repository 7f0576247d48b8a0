"""One seeded drop: the ball's path, the bin it lands in, and a digest of the whole drop."""

import json
import struct
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import KIND_WALL, PHYSICS_VERSION
from plinko.engine.drops.certainty import Certainty, certainty_of
from plinko.engine.drops.drawing import MOMENTS, path_svg
from plinko.engine.drops.flight import Flight
from plinko.engine.drops.start import aim_of, start_of, unsigned_zero
from plinko.engine.drops.trajectory import at_start, follow
from plinko.engine.errors import ParameterError
from plinko.engine.notebooks import figure, png
from plinko.engine.parameters import Solver, SolverName, make_solver
from plinko.engine.seeding import parse_seed

STATE = np.dtype([(name, "<f8") for name in ("t", "x", "y", "theta", "vx", "vy", "omega")])
"""A state of a ball: s, m, rad, m/s, rad/s."""

_STATE_ORDER = (0, 1, 2, 5, 3, 4, 6)  # columns of STATE in the kernels' t x y vx vy theta omega


@dataclass(frozen=True, eq=False, repr=False)
class Drop(Flight):
    """The outcome of a drop, made by the function `drop`.

    Drops are equal if their digests are: the same start on the same board, whether it was given by
    seed, aim or x. aim: the middle in m of the starts that seeds draw, if the player chose one.
    """

    seed: int | None
    explicit_x: bool
    aim: float | None = None

    def __eq__(self, other: object) -> bool:
        return self.digest == other.digest if isinstance(other, Drop) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        start = f"x={self.x_start!r}" if self.explicit_x else f"seed={self.seed}"
        if self.aim is not None:
            start += f" aim={self.aim!r}"
        end = self.unsettled or f"bin {self.bin}, score {self.score:g}"
        return (
            f"<Drop {start} on {self.board.name!r}: {end} after {self.duration:.3f} s and "
            f"{len(self.impacts)} impacts, digest {self.digest[:12]}>"
        )

    def _repr_html_(self) -> str:
        moments = np.linspace(0.0, self.duration, MOMENTS)
        rows = self.states(np.union1d(moments, self.impacts["t"]))
        return figure(path_svg(self.board, rows["x"], rows["y"]), repr(self))

    def _repr_png_(self) -> bytes | None:
        return png(self)

    @property
    def solver(self) -> Solver:
        """The solver with its parameters."""
        return self.trajectory.solver

    @property
    def label(self) -> str | None:
        """Label of the bin, such as its prize; None if it has none or the ball did not land."""
        return self.board.bins.label_of(self.bin)

    @property
    def impacts(self) -> npt.NDArray[np.void]:
        """All events in order, shape (n,), dtype IMPACT, read-only.

        `plinko.engine.constants` has the kinds.
        """
        return self.trajectory.impacts

    @property
    def impact_count(self) -> int:
        """Number of impacts on pegs and walls, as in a batch."""
        return int(np.count_nonzero(self.impacts["kind"] <= KIND_WALL))

    @cached_property
    def certainty(self) -> Certainty:
        """How small changes grow along the path; ParameterError unless the solver is exact."""
        return certainty_of(self.trajectory)

    @property
    def amplification(self) -> float | None:
        """Metres that x_end moves per metre that the start moves; None if the ball did not land."""
        return self.certainty.amplification

    @property
    def certain(self) -> bool:
        """Whether the bin stays the same if the start moves by half a unit in the last place."""
        return self.certainty.certain

    def states(self, times: npt.ArrayLike) -> npt.NDArray[np.void]:
        """States at `times` (shape (n,), s since the start), dtype STATE, in a new array.

        ParameterError for a time before the start; after its end the ball stays where it is.
        """
        at = np.atleast_1d(np.asarray(times, np.float64))
        if not (at >= 0.0).all():
            bad = at[~(at >= 0.0)][0]
            raise ParameterError(f"time {bad} is before the start of the drop", field="times")
        columns = self.trajectory.states_at(at)
        rows = np.empty(len(at), STATE)
        for name, column in zip(STATE.names or (), _STATE_ORDER, strict=True):
            rows[name] = columns[:, column]
        return rows

    def to_dict(self, *, certainty: bool = False) -> dict[str, Any]:
        """The drop's record as JSON values, which `verify` reproduces; see docs/records.md.

        certainty: also include how certain the bin is.
        """
        board, solver, label = self.board, self.solver, self.label
        record: dict[str, Any] = {
            "board": board.preset_name or board.to_dict(),
            "board_digest": board.digest,
            "seed": None if self.seed is None else str(self.seed),
        }
        if self.explicit_x:
            record["x"] = self.x_start
        if self.aim is not None:
            record["aim"] = self.aim
        record["solver"] = solver.name
        record |= solver.fields()
        record["physics_version"] = PHYSICS_VERSION
        record["bin"] = self.bin
        record["score"] = self.score
        if label is not None:
            record["label"] = label
        record["duration"] = self.duration
        record["x_end"] = self.x_end
        record["impacts"] = list(map(list, _ROW.iter_unpack(self.impacts.data)))
        record["digest"] = self.digest
        if certainty:
            record["amplification"] = self.amplification
            record["x_error"] = self.certainty.error
            record["certain"] = self.certain
        return record

    def to_json(self, *, certainty: bool = False) -> str:
        """The record as one line of JSON, as `plinko drop --json` prints it.

        msgspec encodes the impacts, which is faster, if no number needs an exponent: it writes
        those otherwise than Python.
        """
        record = self.to_dict(certainty=certainty)
        size = np.abs(self.trajectory.events)
        if not ((size >= _FIXED[0]) & (size < _FIXED[1]) | (size == 0.0)).all():
            return _json(record)
        rows = msgspec.json.encode(record["impacts"]).decode().replace(",", ", ")
        record["impacts"] = []
        return _json(record).replace('"impacts": []', f'"impacts": {rows}')


_FIXED: Final = (1e-4, 1e16)
"""Range of |x| in which Python writes x without an exponent."""

_ROW: Final = struct.Struct("<6d2i")
"""An impact, as in dtype IMPACT."""

_json: Final = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode


def drop(
    board: Board | str,
    seed: int | str | None = None,
    *,
    x: float | None = None,
    aim: float | None = None,
    solver: SolverName = "exact",
    dt: float | None = None,
    substeps: int | None = None,
    correction: float | None = None,
) -> Drop:
    """Drop a ball at rest from the start that `seed` draws, or from an explicit `x` in m.

    board: a Board, or a preset's name. aim: the middle in m of the starts that seeds draw (default:
    the board's own). dt (s), substeps, correction: of the stepped solver, with defaults.

    Raises BoardError, SeedError or ParameterError naming the bad value.
    """
    chosen = make_solver(solver, dt, substeps, correction)
    number = None if seed is None else parse_seed(seed)
    return make_drop(Board.named(board), number, unsigned_zero(x), chosen, aim)


def make_drop(
    board: Board, seed: int | None, x: object, solver: Solver, aim: object = None
) -> Drop:
    """`drop`, for a board, a seed and a solver that are already parsed."""
    start = at_start(board, start_of(board, seed, x, aim))
    middle = None if aim is None else aim_of(board, aim)
    return Drop(board, follow(board, start, solver), seed, x is not None, middle)
