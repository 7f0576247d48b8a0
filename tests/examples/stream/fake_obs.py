"""OBS as the stream kit sees it: OBS WebSocket 5, in MessagePack.

After the public description: github.com/obsproject/obs-websocket, docs/generated/protocol.md.
"""

import asyncio
import base64
import contextlib
import hashlib
from collections.abc import AsyncIterator
from typing import Any, Final

import msgspec
from websockets.asyncio.server import Server, ServerConnection, serve

PASSWORD: Final = "supersecret"
_SALT, _CHALLENGE = "lM1GncleQOaCu9lT1yeUZhFYnqhsLLP1G5lAGo3ixaI=", "+IxH4CnCiqpX1rM9scsNynZzbOe4"


class FakeObs:
    def __init__(self) -> None:
        self.port = 0
        self.scene = "Game"
        self.scenes: list[str] = []  # in the order in which they were shown
        self.items: dict[str, bool] = {"Confetti": False}  # of each scene, and whether it is shown
        self.shown: list[tuple[str, bool]] = []
        self.inputs: dict[str, dict[str, Any]] = {"Plinko": {}, "Sounds": {}}
        self.played: list[str] = []
        self.refused = 0
        self._server: Server | None = None

    @property
    def rules(self) -> str:
        return (
            f'[obs]\naddress = "ws://127.0.0.1:{self.port}"\nstage = "Plinko"\nsounds = "Sounds"\n'
        )

    async def start(self) -> None:
        """At the same port each time."""
        protocols: Any = ["obswebsocket.msgpack"]
        self._server = await serve(self.talk, "127.0.0.1", self.port, subprotocols=protocols)
        self.port = next(iter(self._server.sockets)).getsockname()[1]

    async def kill(self) -> None:
        assert self._server is not None
        for connection in self._server.connections:
            connection.transport.abort()
        self._server.close()
        with contextlib.suppress(TimeoutError):  # handlers that do not notice it
            await asyncio.wait_for(self._server.wait_closed(), 0.5)

    async def talk(self, client: ServerConnection) -> None:
        assert client.subprotocol == "obswebsocket.msgpack"
        asked = {"challenge": _CHALLENGE, "salt": _SALT}
        hello = {"obsWebSocketVersion": "5.5.2", "rpcVersion": 1, "authentication": asked}
        await client.send(msgspec.msgpack.encode({"op": 0, "d": hello}))
        identify = msgspec.msgpack.decode(await client.recv(decode=False))
        assert (identify["op"], identify["d"]["rpcVersion"]) == (1, 1)
        if identify["d"].get("authentication") != _hash(_hash(PASSWORD + _SALT) + _CHALLENGE):
            self.refused += 1
            await client.close(4009, "Authentication failed.")
            return
        await client.send(msgspec.msgpack.encode({"op": 2, "d": {"negotiatedRpcVersion": 1}}))
        async for frame in client:
            assert isinstance(frame, bytes)
            request = msgspec.msgpack.decode(frame)
            assert request["op"] == 6
            kind, data = request["d"]["requestType"], request["d"].get("requestData") or {}
            found = self.answer(kind, data)
            status: dict[str, Any] = {"result": True, "code": 100}
            if found is None:
                status = {"result": False, "code": 600, "comment": "No source was found."}
            reply = {"requestType": kind, "requestId": request["d"]["requestId"],
                     "requestStatus": status, "responseData": found or {}}  # fmt: skip
            await client.send(msgspec.msgpack.encode({"op": 7, "d": reply}))

    def answer(self, kind: str, data: dict[str, Any]) -> dict[str, Any] | None:
        """The response to a request; None: it fails."""
        if kind == "GetCurrentProgramScene":
            return {"currentProgramSceneName": self.scene}
        if kind == "SetCurrentProgramScene":
            self.scene = data["sceneName"]
            self.scenes.append(self.scene)
        elif kind == "GetSceneItemId":
            names = list(self.items)
            known = data["sourceName"] in names
            return {"sceneItemId": names.index(data["sourceName"])} if known else None
        elif kind == "SetSceneItemEnabled":
            name = list(self.items)[data["sceneItemId"]]
            self.items[name] = data["sceneItemEnabled"]
            self.shown.append((name, self.items[name]))
        elif kind == "SetInputSettings":
            if data["inputName"] not in self.inputs:
                return None
            self.inputs[data["inputName"]] |= data["inputSettings"]
        else:
            assert kind == "TriggerMediaInputAction"
            assert data["mediaAction"] == "OBS_WEBSOCKET_MEDIA_INPUT_ACTION_RESTART"
            self.played.append(self.inputs[data["inputName"]]["local_file"])
        return {}


def _hash(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


@contextlib.asynccontextmanager
async def fake_obs() -> AsyncIterator[FakeObs]:
    obs = FakeObs()
    await obs.start()
    try:
        yield obs
    finally:
        await obs.kill()
