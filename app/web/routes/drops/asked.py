"""The drop that an address asks for: what of the path and the query decides it, checked."""

from typing import Annotated

from fastapi import Depends, Query

from app.computing.tasks import Ask
from app.web.routes.common import Server, chosen_solver
from app.web.routes.queries import Number, Whole
from engine.drops.start import start_of
from engine.seeding import parse_seed

X = Annotated[Number | None, Query(description="Explicit start in metres; else the seed decides.")]
Aim = Annotated[
    Number | None, Query(description="Middle of what the seed draws, m; else x of the board.")
]
SolverName = Annotated[str, Query(description="`exact` or `stepped`.")]
Dt = Annotated[
    Number | None, Query(description="Step in seconds, of the stepped solver alone; 1/60.")
]
Substeps = Annotated[
    Whole | None, Query(description="Substeps a step, of the stepped solver alone; 4.")
]


async def asked(
    board: str,
    seed: str,
    server: Server,
    x: X = None,
    aim: Aim = None,
    solver: SolverName = "exact",
    dt: Dt = None,
    substeps: Substeps = None,
) -> Ask:
    """The drop of a request; raises the errors of what cannot be found or computed."""
    how = chosen_solver(solver, dt, substeps)
    found, number = server.boards.find(board), parse_seed(seed)
    start_of(found, number, x, aim)  # what cannot start has no name either
    return Ask(found, number, x, how, aim)


Asked = Annotated[Ask, Depends(asked)]
