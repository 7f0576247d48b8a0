"""Puts the application together, starts it and stops it."""

import asyncio
import contextlib
import functools
import logging
import os
import secrets
import signal
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Coroutine, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import FastAPI

from plinko.app.errors import SettingError
from plinko.app.fairness.check import kernel_digest_of
from plinko.app.listening import listen, server_over, wait_for
from plinko.app.live.arriving import any_room
from plinko.app.live.broadcast.hub import Hub
from plinko.app.live.registry import Rooms
from plinko.app.live.retention import Retention
from plinko.app.live.sessions.fair_sessions import FairSessions
from plinko.app.ops import logs
from plinko.app.ops.metrics import Metrics
from plinko.app.persistence.checks.integrity import Integrity
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.persistence.ledger.common_secrets import TOKENS, common_secret
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.ledger.writer import COMMIT_PATIENCE, Ledger
from plinko.app.persistence.room_log import RoomLogs
from plinko.app.persistence.service import PersistenceService
from plinko.app.persistence.signing_key import SigningKey, orphans, secret_file
from plinko.app.relay.bus import readings as bus_readings
from plinko.app.relay.bus import redis_at
from plinko.app.relay.feed import feed_relays
from plinko.app.rooms import kinds
from plinko.app.rooms.boards import MAX_BOARDS, Boards
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.settings import TICK_RATE, Settings, not_settings, page_kernels
from plinko.app.web.application import Application
from plinko.app.web.computing import Computing
from plinko.app.web.edge.addresses import Proxies
from plinko.app.web.limits import KeyedBuckets, Quota
from plinko.app.web.readings import readings
from plinko.app.web.returns import Returns
from plinko.app.web.routes.page import Page
from plinko.app.web.services import Services
from plinko.app.web.shared import Others
from plinko.app.web.tokens import SessionTokens, Tokens, secret_of
from plinko.app.webhooks.targets import Target, read_targets
from plinko.engine import Board, World, __version__, preset_names
from plinko.engine.errors import BoardError, shorten
from plinko.engine.jit import limits, native

if TYPE_CHECKING:
    from plinko.app.cluster.start import Cluster
    from plinko.app.webhooks.sender import Webhooks

_log = logging.getLogger("plinko")

_QUIET_START = 5.0  # s until the server prepares its workers, if no request has needed them yet


def create_app(settings: Settings | None = None) -> FastAPI:
    """The application for `settings`; raises SettingError for settings that cannot be used."""
    settings = settings or Settings()
    services = _services(settings)
    cluster = services.others
    app = Application(settings, _lifespan, cluster.surround if cluster else lambda app: app)
    app.state.services = services
    app.state.cluster = cluster
    bus = app.state.bus = redis_at(settings.relays) if settings.relays else None
    if bus is not None:
        services.metrics.read_from(lambda: bus_readings(bus))
    return app


def _services(settings: Settings) -> Services:
    known = Boards(MAX_BOARDS)
    hub = Hub(settings.max_clients)
    metrics = Metrics()
    computing = Computing(settings.workers)
    database = Database(settings.ledger_url, shared=bool(settings.name), beside=settings.epoch_file)
    shares = _Shares(settings) if settings.name else None
    targets = read_targets(settings.webhooks)
    ledger = Ledger(
        database,
        period=1.0 / TICK_RATE,
        patience=COMMIT_PATIENCE,
        on_commit=metrics.ledger_commit.observe,
        leases=shares.book if shares else None,
        targets=[target.url for target in targets],
    )
    limits = kinds.BallLimits(settings.max_balls, kinds.MAX_TOUCHING)
    persistence = PersistenceService(
        ledger,
        limits=limits,
    )
    registry = Rooms(
        settings,
        known,
        hub,
        _main_board(settings.board),
        persistence,
        ticked=(metrics.ticked, computing.cameras.ticked),
        filmed=computing.cameras.films,
        claim=shares.alive.claim if shares else any_room,
    )
    if database.shared and not settings.secret:
        secret = common_secret(database, TOKENS)
    else:
        secret = secret_of(settings.secret, secret_file(database, settings.data_directory))
    others = shares.cluster(registry, ledger) if shares else None
    server = Services(
        settings=settings,
        version=__version__,
        boards=known,
        hub=hub,
        rooms=registry,
        ledger=ledger,
        integrity=Integrity(ledger),
        returns=Returns(ledger),
        tokens=Tokens(secret),
        fair=_fair_sessions(persistence, SigningKey(database, settings.data_directory), registry),
        session_tokens=SessionTokens(secret),
        computing=computing,
        room_drops=KeyedBuckets(settings.drop_rate, 2 * settings.drop_rate),
        creators=Quota("rooms of this address"),
        logs=RoomLogs(persistence.runs, None if database.in_memory else computing.readers.run),
        metrics=metrics,
        others=others,
        webhooks=_webhooks(targets, ledger, others) if targets else None,
    )
    metrics.read_from(functools.partial(readings, server))
    return server


class _Shares:
    """The parts of a server that shares its ledger; a single server does not even import them."""

    def __init__(self, settings: Settings) -> None:
        from plinko.app.cluster import start  # noqa: PLC0415 - only a cluster needs it

        self._settings = settings
        # A new name in the ledger at each start, so that leases of an earlier run are not ours.
        holder = f"{settings.name}.{secrets.token_hex(4)}"
        self.book = LeaseBook(holder, settings.address.rstrip("/"))
        self.alive = start.member(settings, self.book)

    def cluster(self, rooms: Rooms, ledger: Ledger) -> "Cluster":
        """The part that the application starts and stops, and that routes use as `Others`."""
        from plinko.app.cluster.start import Cluster  # noqa: PLC0415 - as above

        return Cluster(self._settings, self.alive, rooms.stored, ledger)


def _webhooks(targets: Sequence[Target], ledger: Ledger, others: Others | None) -> "Webhooks":
    """The senders of webhooks; in a cluster only the first server sends."""
    from plinko.app.webhooks.sender import Webhooks  # noqa: PLC0415 - only with targets

    return Webhooks(targets, ledger, lambda: others is None or others.first)


def _fair_sessions(
    persistence: PersistenceService, key: SigningKey, registry: Rooms
) -> FairSessions:
    return FairSessions(
        persistence,
        key,
        kernel_digest=kernel_digest_of(page_kernels().read_bytes()),
        draw=secrets.token_bytes,
        new_id=lambda: secrets.token_hex(16),
        having=registry.stored.having,
    )


def _main_board(name: str) -> Board:
    """The board of the room `main`: a preset or a JSON file."""
    try:
        return Board.preset(name) if name in preset_names() else Board.from_json(Path(name))
    except (BoardError, OSError) as error:
        raise SettingError(f"board {shorten(name)}: {error}", field="board") from error


@contextlib.asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    """Start the server's parts, each upon those before it; at the end stop the last one first."""
    server: Services = app.state.services
    async with (
        _computing(server),
        _ledger(server),
        _rooms(server, app.state.cluster),
        _web(server, app),
        _operation(server),
    ):
        yield


@contextlib.asynccontextmanager
async def _computing(server: Services) -> AsyncIterator[None]:
    """Compile the physics; at the end close the workers."""
    await asyncio.to_thread(_warm_up)
    server.warm = True
    try:
        yield
    finally:
        server.computing.close()


@contextlib.asynccontextmanager
async def _ledger(server: Services) -> AsyncIterator[None]:
    await asyncio.to_thread(open_ledger, server)
    server.ledger.start()
    try:
        yield
    finally:
        await server.ledger.close()


@contextlib.asynccontextmanager
async def _rooms(server: Services, cluster: "Cluster | None") -> AsyncIterator[None]:
    """Read the rooms, then tick; at the end rooms write their last results.

    In a cluster, ticks begin when the other servers know of this one, or after five seconds.
    """
    await server.fair.load()
    await server.rooms.resume()
    async with _running(cluster=cluster.run() if cluster else asyncio.sleep(0)):
        if cluster is not None:
            await cluster.alive.until_known()
        try:
            async with (
                _running(ticker=server.rooms.ticker.run()) as (server.ticking,),
                _running(following=server.rooms.follow()),
            ):
                yield
        finally:
            server.rooms.leave()


@contextlib.asynccontextmanager
async def _web(server: Services, app: FastAPI) -> AsyncIterator[None]:
    """Prepare pages and workers, and send events to the relays."""
    prepare = server.computing.workers.prepare
    preparing = asyncio.get_running_loop().call_later(_QUIET_START, prepare)
    feeding = feed_relays(app.state.bus, server.rooms, server.client_ids)
    rest = asyncio.to_thread(_warm_up_rest, app.state.page)
    try:
        async with _running(feeding=feeding, rest=rest):
            yield
    finally:
        preparing.cancel()


@contextlib.asynccontextmanager
async def _operation(server: Services) -> AsyncIterator[None]:
    """Check the ledger, delete what is older than the server keeps it, and send webhooks."""
    retention = Retention(
        server.ledger,
        server.fair,
        server.settings.retention,
        mine=lambda: server.others is None or server.others.first,
        now=server.rooms.persistence.now,
    )
    sending = server.webhooks.run() if server.webhooks else asyncio.sleep(0)
    looking = server.integrity.look()
    async with _running(retention=retention.run(), webhooks=sending, integrity=looking):
        yield


@contextlib.asynccontextmanager
async def _running(**work: Coroutine[Any, Any, Any]) -> AsyncIterator[list[asyncio.Task[Any]]]:
    """Run these by name as tasks, until the block ends."""
    tasks = [asyncio.create_task(each, name=name) for name, each in work.items()]
    try:
        yield tasks
    finally:
        for task in tasks:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task


def open_ledger(server: Services) -> None:
    """Open the ledger and check its keys; does nothing the second time. Raises SettingError."""
    server.ledger.open()
    try:
        server.fair.key.settle(time.time())
    except SettingError:
        server.ledger.database.close()
        raise
    found = orphans(server.ledger.database, server.tokens.mark, time.time())
    if found.rooms or found.sessions:
        _log.error(
            "the secret of tokens has changed: the owners of %d open rooms and the "
            "players of %d open sessions get 403; restore it from a backup (%s, or PLINKO_SECRET)",
            found.rooms,
            found.sessions,
            secret_file(server.ledger.database, server.settings.data_directory),
        )


def _warm_up() -> None:
    """Compile the physics, so that no request waits for it."""
    world = World(Board.preset("triangle-8"), solver="exact")
    world.add(seed=0)
    world.step()


def _warm_up_rest(site: Page) -> None:
    """The rest of the warm-up, while the server already runs: pages and touching balls."""
    site.prepare()
    touching = TouchingRoom("warm-up", Board.preset("triangle-8"), tick_rate=60, max_balls=2)
    touching.drop(DropCommand(0))
    touching.step(watched=True)
    touching.diagnostics()


def _check_temporary() -> None:
    """Raise SettingError if there is no directory for temporary files, which workers need."""
    try:
        tempfile.gettempdir()
    except FileNotFoundError:
        raise SettingError(
            "no directory for temporary files can be written, and the server's worker processes "
            "need one: mount a file system at /tmp (`--tmpfs /tmp`), or name a directory in TMPDIR",
            field="tmpdir",
        ) from None


def check(settings: Settings) -> None:
    """Raise SettingError if no server can start with these settings; log what has no effect.

    It opens no port and no ledger.
    """
    logs.configure(settings.log_level, settings.log_format)
    for line in not_settings(os.environ):
        _log.warning(line)
    _check_temporary()
    _main_board(settings.board)
    read_targets(settings.webhooks)
    Proxies(settings.trusted_proxies)
    Database(settings.ledger_url, shared=bool(settings.name))
    if settings.relays:
        redis_at(settings.relays)


def run(settings: Settings | None = None) -> None:
    """Serve until SIGINT or SIGTERM; raises SettingError if it cannot start with these settings."""
    settings = settings or Settings()
    check(settings)
    native.forbid()  # only WebAssembly, whose calls can be limited
    limits.limit_calls()  # all rooms share one thread: a call that does not end would stop them
    with listen(settings) as listener:
        wait_for(Database(settings.ledger_url).missing, listener)
        app = create_app(settings)
        open_ledger(app.state.services)
        if app.state.cluster is not None:
            app.state.cluster.listens(listener)
        server = server_over(app, settings)
        # After an orderly end uvicorn raises the signal that stopped it again; ignore that one.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: None)
        if not sys.stdin or not sys.stdin.isatty():
            # Log rotation sends SIGHUP. On a terminal it means that the terminal has closed.
            signal.signal(signal.SIGHUP, signal.SIG_IGN)
        server.run(sockets=[listener])
