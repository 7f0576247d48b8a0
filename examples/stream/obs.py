"""OBS over its WebSocket, version 5: scenes, sources, sounds, and the address of the stage."""

import asyncio
import json
import logging
import os
import time
from pathlib import Path
from typing import Any

import simpleobsws
from journal import Journal
from rules import Obs as Settings
from websockets.exceptions import WebSocketException

FAULTS = (OSError, WebSocketException, TimeoutError, simpleobsws.MessageTimeout,
          simpleobsws.NotIdentifiedError)  # fmt: skip
PAUSE, TURN = 2.0, 0.2  # s between two attempts, and between two looks at the journal
RESTART = "OBS_WEBSOCKET_MEDIA_INPUT_ACTION_RESTART"

log = logging.getLogger("kit")


class Obs:
    def __init__(self, journal: Journal, settings: Settings) -> None:
        self.journal, self.settings = journal, settings
        password = settings.password or os.environ.get("OBS_PASSWORD", "")
        self.socket = simpleobsws.WebSocketClient(settings.address, password)
        self.shown = ""  # the stage's address in OBS
        self.fault = ""  # the last one

    async def run(self) -> None:
        """Do what is posted for OBS, for ever; what waits too long meanwhile is dropped."""
        while True:
            try:
                await self._work()
            except FAULTS as error:
                if self.fault != (fault := str(error) or type(error).__name__):
                    log.warning("OBS: %s", fault)
                self.fault = fault
                await asyncio.sleep(PAUSE)

    async def _work(self) -> None:
        if not self.socket.is_identified():
            await self.socket.disconnect()
            self.shown = ""
            await self.socket.connect()
            if not await self.socket.wait_until_identified():
                raise OSError("not connected; is the password right?")
        if self.settings.stage and self.shown != self.journal.stage:
            self.shown = self.journal.stage
            await self._set(self.settings.stage, url=self.shown)
        rows = self.journal.posted("scene", "source", "sound", "back", "hide")
        for row in rows:
            await getattr(self, f"_{row['kind']}")(*json.loads(row["data"]))
            self.journal.done([row])
        await asyncio.sleep(TURN)

    async def _ask(self, kind: str, **data: Any) -> dict[str, Any]:
        reply = await self.socket.call(simpleobsws.Request(kind, data or None))
        if not reply.ok():
            log.warning("OBS: %s %s: %s", kind, data, reply.requestStatus.comment)
        return reply.responseData or {}

    async def _set(self, source: str, **settings: Any) -> None:
        await self._ask("SetInputSettings", inputName=source, inputSettings=settings)

    async def _scene(self, name: str, seconds: float) -> None:
        before = (await self._ask("GetCurrentProgramScene")).get("currentProgramSceneName")
        if before and before != name:  # posted first, so that a crash leaves no scene behind
            self._later("back", [before, name], seconds)
            await self._back(name)

    async def _back(self, name: str, after: str = "") -> None:
        """Show a scene, unless somebody has left the scene `after` meanwhile."""
        shown = (await self._ask("GetCurrentProgramScene")).get("currentProgramSceneName")
        if after in ("", shown):
            await self._ask("SetCurrentProgramScene", sceneName=name)

    async def _source(self, name: str, seconds: float) -> None:
        scene = (await self._ask("GetCurrentProgramScene")).get("currentProgramSceneName")
        found = await self._ask("GetSceneItemId", sceneName=scene, sourceName=name)
        if "sceneItemId" in found:
            self._later("hide", [scene, found["sceneItemId"], False], seconds)
            await self._hide(scene, found["sceneItemId"], True)

    async def _hide(self, scene: Any, item: int, shown: bool) -> None:
        await self._ask(
            "SetSceneItemEnabled", sceneName=scene, sceneItemId=item, sceneItemEnabled=shown
        )

    async def _sound(self, name: str, _: float) -> None:
        source = self.settings.sounds
        await self._set(source, local_file=str(Path(self.settings.folder, name).resolve()))
        await self._ask("TriggerMediaInputAction", inputName=source, mediaAction=RESTART)

    def _later(self, kind: str, data: Any, seconds: float) -> None:
        with self.journal.db:
            self.journal.post(kind, data, due=time.time() + seconds, keep=86_400.0)
