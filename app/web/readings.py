"""Metrics that are read from the server's parts when they are requested."""

from collections.abc import Iterator

from plinko.app.ops.metrics import Reading
from plinko.app.web.services import Services
from plinko.app.web.shared import Standing
from plinko.engine import PHYSICS_VERSION


def readings(server: Services) -> Iterator[Reading]:
    info = {"version": server.version, "physics_version": str(PHYSICS_VERSION)}
    yield "plinko_info", "The versions that run here.", 1, info
    yield from server.returns.readings()
    if server.others is not None:
        yield from standing_readings(server.others.standing())
    if server.webhooks is not None:
        yield from server.webhooks.readings()
    counts, text = server.rooms.runner.counts, "Drops in rooms that were not accepted, by result."
    for result, count in (("refused", counts.refused), ("undecided", counts.undecided)):
        yield "plinko_drops_refused_total", text, count, {"result": result}
    for name, text, value in _values(server):
        yield f"plinko_{name}", text, value, {}


def standing_readings(stands: Standing) -> Iterator[Reading]:
    process = {"process": stands.name}
    yield "plinko_cluster_leases_up", "1 while it sees the others.", stands.leases, process
    yield "plinko_cluster_members", "Servers that are alive.", len(stands.members), process
    yield "plinko_cluster_rooms", "Rooms of this server.", stands.rooms, process
    text = "Rooms taken over from failed servers."
    yield "plinko_cluster_taken_over_total", text, stands.failed_over, process
    text = "Rooms given to other servers."
    yield "plinko_cluster_handed_over_total", text, stands.migrated, process
    text = "Requests and connections forwarded to the server that has the room."
    yield "plinko_cluster_handed_on_total", text, stands.forwarded, process


def _values(server: Services) -> Iterator[tuple[str, str, float]]:
    ticker = server.rooms.ticker
    yield "ticker_asleep", "1 while nothing moves and no tick runs.", ticker.asleep
    yield "ticks_total", "Ticks run.", ticker.ticks
    yield "tick_overruns_total", "Times that more than one tick was due.", ticker.schedule.overruns
    yield "ticks_skipped_total", "Ticks skipped after a pause.", ticker.schedule.skipped
    runner = server.rooms.runner
    text = "Ticks of rooms skipped because a pass had no time for them."
    yield "room_ticks_skipped_total", text, runner.counts.skipped
    text = "Ticks missed by rooms that had not ticked for a second."
    yield "room_late_ticks_total", text, runner.counts.late

    rooms = server.rooms
    yield "rooms", "Open rooms in memory.", len(rooms.all())
    yield "rooms_awake", "Rooms in which something moves.", len(rooms.runner.awake)
    yield "balls", "Balls in flight.", sum(room.world.count for room in rooms.runner.awake)
    yield "drops_total", "Drops accepted in rooms.", rooms.runner.counts.accepted
    yield "landings_total", "Balls in rooms that have landed.", rooms.runner.counts.landed
    text = "Drops without a bin because they failed the solver's check."
    yield "solver_errors_total", text, rooms.runner.counts.solver_errors
    jobs = server.computing.workers.jobs
    yield "jobs", "Drops, pictures and checks being computed or waiting.", jobs

    ledger = server.ledger
    yield "ledger_up", "1 while the ledger takes writes.", ledger.up
    yield "ledger_commits_total", "Groups of writes committed.", ledger.commits
    yield "ledger_failures_total", "Groups of writes that failed.", ledger.failures
    text = "Size of SQLite's write-ahead log."
    yield "ledger_log_bytes", text, ledger.database.log_bytes
    sound = server.integrity.finding != "damaged"
    yield "ledger_sound", "0 if the ledger's database found itself damaged.", sound
    recovery = server.rooms.persistence.recovery
    damaged = len(recovery.set_aside)
    yield "rooms_set_aside", "Rooms that cannot open because their record is damaged.", damaged

    traffic = server.hub.traffic
    yield "clients", "Clients connected to rooms.", server.hub.total
    yield "frames_sent_total", "WebSocket messages sent.", traffic.frames
    yield "sent_bytes_total", "Bytes of those messages.", traffic.bytes
    yield "frames_skipped_total", "Snapshots that a newer one replaced unsent.", traffic.skipped
    yield "clients_too_slow_total", "Clients closed because they did not read.", traffic.too_slow

    yield "pictures_total", "Pictures drawn on request.", server.computing.pictures.drawn
    yield "cameras", "Live picture streams being drawn.", server.computing.cameras.running
    yield "viewers", "Viewers of live picture streams.", server.computing.cameras.viewers
    yield "camera_frames_total", "Frames drawn for live streams.", server.computing.cameras.drawn
