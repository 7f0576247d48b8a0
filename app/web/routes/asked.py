"""The drop that an address asks for: what of the path and the query decides it, checked."""

from typing import Annotated

from fastapi import Depends, Query

from app.computing.tasks import Ask
from app.web.routes.common import Server, check_step
from engine.parameters import DEFAULT_DT, DEFAULT_SUBSTEPS, make_solver
from engine.seeding import parse_seed

X = Annotated[float | None, Query(description="Explicit start in metres; else the seed decides.")]
SolverName = Annotated[str, Query(description="`exact` or `stepped`.")]
Dt = Annotated[float, Query(description="Step of the stepped solver, in seconds.")]
Substeps = Annotated[int, Query(description="Substeps a step, of the stepped solver.")]


async def asked(
    board: str,
    seed: str,
    server: Server,
    x: X = None,
    solver: SolverName = "exact",
    dt: Dt = DEFAULT_DT,
    substeps: Substeps = DEFAULT_SUBSTEPS,
) -> Ask:
    """The drop of a request; raises the errors of what cannot be found or computed."""
    check_step(server, solver, dt, substeps)
    found, number = server.boards.find(board), parse_seed(seed)
    return Ask(found, number, x, make_solver(solver, dt, substeps))


Asked = Annotated[Ask, Depends(asked)]
