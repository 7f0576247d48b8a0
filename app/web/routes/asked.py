"""The drop that an address asks for: what of the path and the query decides it, checked."""

from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Query

from app.web.routes.common import Server, chosen_solver
from engine import Board, Drop
from engine.drops.drop import make_drop, unsigned_zero
from engine.parameters import Solver
from engine.seeding import parse_seed

X = Annotated[float | None, Query(description="Explicit start in metres; else the seed decides.")]
SolverName = Annotated[str, Query(description="`exact` or `stepped`.")]
Dt = Annotated[
    float | None, Query(description="Step in seconds, of the stepped solver alone; 1/60.")
]
Substeps = Annotated[
    int | None, Query(description="Substeps a step, of the stepped solver alone; 4.")
]


@dataclass(frozen=True, slots=True)
class Ask:
    """Everything that decides a drop."""

    board: Board
    seed: int
    x: float | None
    solver: Solver

    def drop(self) -> Drop:
        """Compute it; raises ParameterError for a start outside of the drop zone."""
        return make_drop(self.board, self.seed, unsigned_zero(self.x), self.solver)


async def asked(
    board: str,
    seed: str,
    server: Server,
    x: X = None,
    solver: SolverName = "exact",
    dt: Dt = None,
    substeps: Substeps = None,
) -> Ask:
    """The drop of a request; raises the errors of what cannot be found or computed."""
    how = chosen_solver(server, solver, dt, substeps)
    return Ask(server.boards.find(board), parse_seed(seed), x, how)


Asked = Annotated[Ask, Depends(asked)]
