"""Our two solvers. The stepped one takes one substep per step, so that dt is its true step."""

import numpy as np
import numpy.typing as npt

from benchmarks.contestants.common import Contestant, Floats, Observation, Paths, steps_of
from benchmarks.harness.clock import seconds_of
from plinko.engine import Board, drop, drop_many


class Exact(Contestant):
    name = "plinko exact"
    stepped = False
    solver = "exact"

    def options(self, dt: float) -> dict[str, object]:
        """Keyword arguments for `drop` and `drop_many`."""
        return {"solver": self.solver}

    def seconds(self, board: Board, xs: Floats, dt: float) -> float:
        """Wall seconds of a batch on one core."""
        seeds = np.zeros(len(xs), np.uint64)
        options = self.options(dt)
        return seconds_of(lambda: drop_many(board, seeds, xs=xs, threads=1, **options))  # type: ignore[arg-type]

    def paths(self, board: Board, xs: Floats, dt: float, duration: float) -> Paths:
        """States at multiples of dt."""
        times = dt * np.arange(steps_of(duration, dt) + 1)
        positions = np.empty((len(times), len(xs), 2))
        velocities = np.empty_like(positions)
        for i, x in enumerate(xs.tolist()):
            states = drop(board, x=x, **self.options(dt)).states(times)  # type: ignore[arg-type]
            positions[:, i, 0], positions[:, i, 1] = states["x"], states["y"]
            velocities[:, i, 0], velocities[:, i, 1] = states["vx"], states["vy"]
        return Paths(dt, positions, velocities)

    def bins(self, board: Board, xs: Floats, dt: float, duration: float) -> npt.NDArray[np.int64]:
        """The solver's own bins."""
        seeds = np.zeros(len(xs), np.uint64)
        many = drop_many(board, seeds, xs=xs, **self.options(dt))  # type: ignore[arg-type]
        return many.bin.astype(np.int64)

    def observe(
        self, board: Board, xs: Floats, dt: float, times: Floats, duration: float
    ) -> Observation:
        """Like the inherited method, but with exact positions at `times` and the solver's bins."""
        found = np.empty((*times.shape, 2))
        for i, x in enumerate(xs.tolist()):
            states = drop(board, x=x, **self.options(dt)).states(times[i])  # type: ignore[arg-type]
            found[i, :, 0], found[i, :, 1] = states["x"], states["y"]
        deepest = self.paths(board, xs, dt, duration).deepest(board)
        return Observation(found, self.bins(board, xs, dt, duration), deepest)


class Stepped(Exact):
    name = "plinko stepped"
    stepped = True
    solver = "stepped"

    def options(self, dt: float) -> dict[str, object]:
        return {"solver": self.solver, "dt": dt, "substeps": 1}
