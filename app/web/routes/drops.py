"""Drops: compute one, replay it by its address, as a record, as frames; verify."""

import functools
import secrets
import time
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from fastapi import APIRouter, Query, Request, Response

from app.errors import InvalidValueError
from app.protocol.client_messages import parse_x
from app.rooms.log import is_log, verify_log
from app.web.routes.asked import Ask, Asked
from app.web.routes.common import (
    Server,
    body_of,
    cache_headers,
    check_step,
    chosen_solver,
    documented,
    either,
    is_current,
    not_modified,
    optional_seed,
    read,
    reply,
    resolve_board,
)
from app.web.routes.simulate import MAX_SECONDS
from app.web.schemas.drops import DropRecord, DropRequest, Frames, Verdict
from app.web.schemas.rooms import RoomLog
from engine import Drop, verify
from engine.parameters import DEFAULT_DT, DEFAULT_SUBSTEPS

router = APIRouter(prefix="/api/v1", tags=["drops"])

_MAX_FRAMES = 100_000  # rows of one reply, about 10 MB of JSON

Certainty = Annotated[bool, Query(description="Say also how sure the bin is (exact solver).")]
Fps = Annotated[float, Query(gt=0, le=1000, description="Frames a second.")]


@router.post(
    "/drops",
    summary="Compute a drop",
    responses=documented(DropRecord, 400, 404, 413, 422, 503),
    openapi_extra=body_of(DropRequest, {"board": "triangle-16", "seed": "42"}),
)
async def compute_drop(request: Request, server: Server) -> Response:
    """Drop a ball and reply with the whole record: start, every impact, bin, score and digest.

    Without a seed the server draws one; the record names it, so the drop can be replayed.
    """
    body = await read(request, DropRequest)
    solver = chosen_solver(server, body.solver, body.dt, body.substeps)
    seed = optional_seed(body.seed)
    ask = Ask(
        await resolve_board(server, body.board),
        secrets.randbits(64) if seed is None else seed,
        parse_x(body.x),
        solver,
    )
    record = await server.workers.run(lambda: ask.drop().record(certainty=body.certainty))
    return reply(record, headers={"etag": f'"{record["digest"]}"'})


@router.get(
    "/drops/{board}/{seed}/frames",
    summary="Sample a drop",
    responses=documented(Frames, 304, 404, 422, 503),
)
async def sample_drop(request: Request, server: Server, ask: Asked, fps: Fps = 60.0) -> Response:
    """The ball's state at times 0, 1/fps, 2/fps … and at the landing; and right before each impact.

    The record has the state right after each impact: the two differ by what the impact gave.
    """
    done = await server.workers.run(ask.drop)
    etag = f"{done.digest}.frames.{fps!r}"
    if is_current(request, etag):
        return not_modified(etag)
    body = await server.workers.run(functools.partial(_sample, done, fps))
    return reply(body, headers=cache_headers(etag))


@router.get(
    "/drops/{board}/{seed}",
    summary="Replay a drop",
    responses=documented(DropRecord, 304, 404, 422, 503),
)
async def get_drop(
    request: Request, server: Server, ask: Asked, certainty: Certainty = False
) -> Response:
    """The record of a drop, decided by its address alone, and so cacheable; ETag is its digest."""
    record = await server.workers.run(lambda: ask.drop().record(certainty=certainty))
    digest = record["digest"]
    if is_current(request, digest):
        return not_modified(digest)
    return reply(record, headers=cache_headers(digest))


@router.post(
    "/verify",
    summary="Verify a drop's record or a room's log",
    responses=documented(Verdict, 400, 413, 422, 503),
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/json": {"schema": either(DropRecord, RoomLog)}},
        }
    },
)
async def verify_record(request: Request, server: Server) -> Response:
    """Compute the drop of a record, or all of a room's log, again: is every bit reproduced?

    A record that does not hold is no error: `ok` is false and `field` the first that differs.
    """
    record = await read(request, dict[str, Any])
    if is_log(record):
        check = functools.partial(verify_log, record, _Patience())
        verdict = await server.workers.run(check)
        return reply(Verdict(verdict.ok, verdict.field, verdict.expected, verdict.actual))
    check_step(
        server,
        record.get("solver"),
        record.get("dt", DEFAULT_DT),
        record.get("substeps", DEFAULT_SUBSTEPS),
    )
    verdict = await server.workers.run(functools.partial(verify, record))
    return reply(Verdict(verdict.ok, verdict.field, verdict.expected, verdict.actual))


class _Patience:
    """Called with each tick that is replayed; raises InvalidValueError when it takes too long."""

    def __init__(self) -> None:
        self._started = time.monotonic()

    def __call__(self, tick: int) -> None:
        if time.monotonic() - self._started > MAX_SECONDS:
            raise InvalidValueError(
                f"the log takes too long: {tick} ticks were replayed after {MAX_SECONDS:g} s; "
                "plinko verify takes its time",
                field="tick",
            )


def _sample(done: Drop, fps: float) -> Frames:
    """The states at `fps` and at the landing; raises InvalidValueError when they are too many."""
    count = int(done.duration * fps) + 1
    if count > _MAX_FRAMES:
        raise InvalidValueError(
            f"fps {fps:g} makes {count} frames of a drop of {done.duration:g} s; "
            f"at most {_MAX_FRAMES}",
            field="fps",
        )
    times = np.arange(count) / fps
    if times[-1] < done.duration:
        times = np.append(times, done.duration)
    states = done.states(times)
    return Frames(
        board_digest=done.board.digest,
        digest=done.digest,
        fps=fps,
        duration=done.duration,
        fields=list(states.dtype.names or ()),
        frames=states.tolist(),
        before=_before(done).tolist(),
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
