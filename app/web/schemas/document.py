"""The JSON Schemas of all bodies, for the server's OpenAPI document."""

import msgspec

from app.fairness.export import SessionExport
from app.web.schemas.board_form import BoardForm
from app.web.schemas.boards import BoardList, BoardOdds, BoardView
from app.web.schemas.cluster import ClusterView, MoveRequest, MoveView
from app.web.schemas.drops import (
    DropRecord,
    DropRequest,
    Frames,
    MapTile,
    SeedsFound,
    SeedsRequest,
    Simulation,
    SimulationRequest,
    Verdict,
)
from app.web.schemas.halts import HaltRequest, HaltView
from app.web.schemas.health import Health, IntegrityView, Readiness
from app.web.schemas.payouts import Payouts, PayoutsRequest
from app.web.schemas.players import PlayList
from app.web.schemas.problem import Problem
from app.web.schemas.queues import QueueChange, QueueRequest, QueueView
from app.web.schemas.rooms import (
    RoomChange,
    RoomDrop,
    RoomDropRequest,
    RoomList,
    RoomLog,
    RoomOpened,
    RoomRequest,
    RoomView,
    SceneList,
)
from app.web.schemas.sessions import (
    LogHead,
    SessionBegun,
    SessionEnd,
    SessionOpening,
    SessionRequest,
    SessionView,
)
from engine.json_text import JsonObject

DOCUMENTED = (
    Problem,
    BoardForm,
    BoardList,
    BoardView,
    BoardOdds,
    PayoutsRequest,
    Payouts,
    DropRequest,
    DropRecord,
    Frames,
    MapTile,
    Verdict,
    SimulationRequest,
    Simulation,
    SeedsRequest,
    SeedsFound,
    RoomRequest,
    SceneList,
    RoomChange,
    RoomList,
    RoomView,
    RoomOpened,
    RoomLog,
    RoomDropRequest,
    RoomDrop,
    SessionRequest,
    SessionOpening,
    SessionView,
    SessionBegun,
    SessionEnd,
    SessionExport,
    LogHead,
    Health,
    Readiness,
    IntegrityView,
    HaltRequest,
    HaltView,
    MoveRequest,
    MoveView,
    ClusterView,
    PlayList,
    QueueRequest,
    QueueChange,
    QueueView,
)


def components() -> JsonObject:
    """The JSON Schemas of all bodies, by name, for OpenAPI's components."""
    return msgspec.json.schema_components(DOCUMENTED, ref_template="#/components/schemas/{name}")[1]
