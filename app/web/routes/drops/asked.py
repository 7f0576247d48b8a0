"""The drop that a URL names: parses its path and query into an `Ask`."""

from typing import Annotated

from fastapi import Depends, Query

from plinko.app.computing.tasks import Ask
from plinko.app.web.routes.common import Server, chosen_solver
from plinko.app.web.routes.queries import Number, Whole
from plinko.engine.drops.start import start_of
from plinko.engine.seeding import parse_seed

X = Annotated[
    Number | None, Query(description="Explicit start in metres; default: drawn from the seed.")
]
Aim = Annotated[
    Number | None,
    Query(description="Middle of the starts that seeds draw, m; default: the board's own."),
]
SolverName = Annotated[str, Query(description="`exact` or `stepped`.")]
Dt = Annotated[
    Number | None,
    Query(description="Step in seconds; only for the stepped solver. Default: 1/60."),
]
Substeps = Annotated[
    Whole | None, Query(description="Substeps per step; only for the stepped solver. Default: 4.")
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
    """The drop of a request; raises the errors of unknown boards and invalid values."""
    how = chosen_solver(solver, dt, substeps)
    found, number = server.boards.find(board), parse_seed(seed)
    start_of(found, number, x, aim)  # raises for an invalid start, before a cache could answer 304
    return Ask(found, number, x, how, aim)


Asked = Annotated[Ask, Depends(asked)]
