"""Scenes of touching balls over REST: their names, parameters, ranges and presets."""

from fastapi import Response

from plinko.app.live.public_tables import PUBLIC_SCENES
from plinko.app.rooms.touching.scene import DEFAULTS
from plinko.app.rooms.touching.values import PRESETS, table
from plinko.app.web.routes.common import documented, reply
from plinko.app.web.routes.table import operations
from plinko.app.web.schemas.rooms import SceneList, SceneView

router = operations("rooms", "/api/v1/scenes")


@router.get("", summary="List the scenes", responses=documented(SceneList))
async def list_scenes() -> Response:
    """The scenes that `POST rooms` accepts, with their parameters, ranges and presets.

    A scene is a box without bins, not a board. Each is also a public room.
    """
    scenes = [SceneView(name, room, DEFAULTS[name]) for room, name in PUBLIC_SCENES.items()]
    presets = {name: dict(values) for name, values in PRESETS.items()}
    return reply(SceneList(scenes, table(), presets))
