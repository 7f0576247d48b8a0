"""Drops: compute a drop, replay it by its URL as a record or as frames, verify a record."""

import secrets
from functools import cache
from importlib.util import find_spec
from typing import Annotated

from fastapi import Depends, Query, Request, Response

from plinko.app.computing import prices, tasks
from plinko.app.computing.tasks import Ask
from plinko.app.errors import InvalidValueError
from plinko.app.protocol.client_messages import parse_place
from plinko.app.rooms.log import is_log
from plinko.app.web.routes.common import (
    Server,
    body_of,
    cache_headers,
    check_count,
    check_step,
    chosen_solver,
    compute,
    documented,
    either,
    is_current,
    not_modified,
    optional_seed,
    read,
    reply,
    resolve_board,
    services,
)
from plinko.app.web.routes.queries import Number, Whole
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.drops import (
    DropRecord,
    DropRequest,
    Frames,
    SeedsFound,
    SeedsRequest,
    Simulation,
    SimulationRequest,
    Verdict,
)
from plinko.app.web.schemas.rooms import RoomLog
from plinko.engine.drops.seeds import check_bin
from plinko.engine.drops.start import aim_of, start_of
from plinko.engine.errors import MissingPartError
from plinko.engine.parameters import DEFAULT_DT, DEFAULT_SUBSTEPS, Exact
from plinko.engine.seeding import SEED_LIMIT, parse_seed

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
    request: Request,
    board: str,
    seed: str,
    x: X = None,
    aim: Aim = None,
    solver: SolverName = "exact",
    dt: Dt = None,
    substeps: Substeps = None,
) -> Ask:
    """The drop of a request; raises the errors of unknown boards and invalid values."""
    how = chosen_solver(solver, dt, substeps)
    found, number = services(request).boards.find(board), parse_seed(seed)
    start_of(found, number, x, aim)  # raises for an invalid start, before a cache could answer 304
    return Ask(found, number, x, how, aim)


Asked = Annotated[Ask, Depends(asked)]


router = operations("drops")

Certainty = Annotated[
    bool,
    Query(description="Also estimate the error and whether the bin is certain (exact solver)."),
]
Certified = Annotated[bool, Query(description="Also prove the bin (exact solver).")]
Fps = Annotated[Number, Query(gt=0, le=1000, description="Frames a second.")]


@router.post(
    "/drops",
    summary="Compute a drop",
    responses=documented(DropRecord, 501),
    openapi_extra=body_of(DropRequest, {"board": "triangle-16", "seed": "42"}),
)
async def compute_drop(request: Request, server: Server) -> Response:
    """Drop a ball and return its record: start, every impact, bin, score and digest.

    If no seed is given, the server draws one. The record has it, so the drop can be replayed.
    """
    body = await read(request, DropRequest)
    solver = chosen_solver(body.solver, body.dt, body.substeps)
    seed = optional_seed(body.seed)
    ask = Ask(
        await resolve_board(request, body.board),
        secrets.randbits(64) if seed is None else seed,
        parse_place(body.x, "x"),
        solver,
        parse_place(body.aim, "aim"),
    )
    digest, record = await _record(request, ask, body.certainty, body.certified)
    return reply(record, headers={"etag": f'"{digest}"'})


@router.get(
    "/drops/{board}/{seed}/frames",
    summary="Sample a drop",
    responses=documented(Frames, 304),
)
async def sample_drop(request: Request, ask: Asked, fps: Fps = 60.0) -> Response:
    """The ball's state at times 0, 1/fps, 2/fps …, at the landing, and right before each impact.

    The record has the state right after each impact; the difference is the effect of the impact.
    """
    etag = f"{ask.name}.frames.{fps!r}"
    if is_current(request, etag):
        return not_modified(etag)
    price = prices.one_drop(ask.board, ask.solver)
    body = await compute(request, price, tasks.frames, ask, fps)
    return reply(body, headers=cache_headers(etag))


@router.get(
    "/drops/{board}/{seed}",
    summary="Replay a drop",
    responses=documented(DropRecord, 304, 501),
)
async def get_drop(
    request: Request, ask: Asked, certainty: Certainty = False, certified: Certified = False
) -> Response:
    """The record of a drop. The address decides it, so it can be cached; its digest is the ETag."""
    digest, record = await _record(request, ask, certainty, certified)
    if is_current(request, digest):
        return not_modified(digest)
    return reply(record, headers=cache_headers(digest))


@router.post(
    "/verify",
    summary="Verify a drop's record or a room's log",
    responses=documented(Verdict),
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/json": {"schema": either(DropRecord, RoomLog)}},
        }
    },
)
async def verify_record(request: Request, server: Server) -> Response:
    """Recompute the drop of a record, or all of a room's log, and compare every bit.

    If something differs, that is not an error: `ok` is false, and `field` is the first difference.
    """
    record = await read(request, dict[str, object])
    if is_log(record):
        return reply(await compute(request, prices.verification(), tasks.log_verdict, record))
    check_step(
        record.get("solver"), record.get("dt", DEFAULT_DT), record.get("substeps", DEFAULT_SUBSTEPS)
    )
    return reply(await compute(request, prices.verification(), tasks.verdict, record))


async def _record(
    request: Request, ask: Ask, certainty: bool, certified: bool
) -> tuple[str, bytes]:
    """The digest of a drop, and its record as JSON."""
    if certified:
        check_certified(ask)
        return await compute(request, prices.proof(), tasks.proof, ask, certainty)
    price = (prices.one_drop if certainty else prices.record)(ask.board, ask.solver)
    return await compute(request, price, tasks.record, ask, certainty)


@cache
def _is_installed() -> bool:
    return find_spec("flint") is not None


def require_certifier() -> None:
    """Raise MissingPartError if the packages for proofs are not installed."""
    if not _is_installed():
        raise MissingPartError(
            "this server cannot prove drops; `pip install 'plinko-sim[certify]'` adds proofs",
            field="certified",
        )


def check_certified(ask: Ask) -> None:
    """Raise MissingPartError or InvalidValueError if this drop cannot be proven here."""
    require_certifier()
    if not isinstance(ask.solver, Exact):
        raise InvalidValueError(
            f"certified true needs the solver 'exact', not {ask.solver.name!r}",
            field="certified",
        )


@router.post(
    "/simulate",
    summary="Compute many drops",
    responses=documented(Simulation),
    openapi_extra=body_of(SimulationRequest, {"board": "triangle-16", "drops": 100, "seed": "0"}),
)
async def simulate(request: Request, server: Server) -> Response:
    """Drop balls with the seeds `seed`, `seed` + 1, … and count where they land.

    At most 10,000 drops. `plinko simulate` has no limit and gives the same numbers.
    """
    body = await read(request, SimulationRequest)
    check_count(body.drops, "plinko simulate")
    solver = chosen_solver(body.solver, body.dt, body.substeps)
    first = parse_seed(body.seed)
    parse_seed(first + body.drops - 1)
    board = await resolve_board(request, body.board)
    price = prices.many_drops(board, body.drops, solver)
    found = await compute(request, price, tasks.tally, board, first, body.drops, solver)
    return reply(Simulation(**found))


@router.post(
    "/seeds",
    summary="Find seeds that land in a bin",
    responses=documented(SeedsFound),
    openapi_extra=body_of(SeedsRequest, {"board": "triangle-16", "bin": 8, "count": 3}),
)
async def find_seeds(request: Request, server: Server) -> Response:
    """List the next seeds whose balls land in `bin`, in rising order and without gaps.

    The server tries at most `drops` seeds, up to 10,000. If fewer than `count` of them land in the
    bin, continue with `after` set to the response's `last`. `plinko seeds` has no such limit.
    """
    body = await read(request, SeedsRequest)
    check_count(body.drops, "plinko seeds")
    check_count(body.count, "plinko seeds", "count")
    first = 0 if body.after is None else parse_seed(body.after) + 1
    if first == SEED_LIMIT:
        raise InvalidValueError(f"after {body.after} is the last seed there is", field="after")
    board = await resolve_board(request, body.board)
    check_bin(board, body.bin)
    aim = None if body.aim is None else aim_of(board, body.aim)
    price = prices.many_drops(board, body.drops, Exact())
    asked = (board, body.bin, first, body.count, body.drops, aim)
    found = await compute(request, price, tasks.seeds_in, *asked)
    return reply(SeedsFound(**found))
