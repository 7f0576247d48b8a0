"""Frames written directly to the transport have the same bytes as uvicorn's."""

import asyncio
from collections.abc import Callable
from typing import Any, cast

import pytest
import uvicorn
from hypothesis import given
from hypothesis import strategies as st
from uvicorn.server import ServerState
from websockets.frames import Frame as ReferenceFrame
from websockets.frames import Opcode
from websockets.protocol import State

from plinko.app.live.broadcast.transport import DirectConnection, DirectProtocol
from plinko.app.protocol.wire import WireMessage


@given(st.binary(max_size=300) | st.sampled_from([bytes(65535), bytes(65536)]))
def test_a_frame_is_what_the_websockets_library_makes_of_it(payload: bytes) -> None:
    for frame, opcode in (
        (WireMessage.of_text(payload), Opcode.TEXT),
        (WireMessage.of_bytes(payload), Opcode.BINARY),
    ):
        assert frame.wire == ReferenceFrame(opcode, payload).serialize(mask=False)


@pytest.mark.parametrize("size", [0, 125, 126, 65535, 65536])
@pytest.mark.parametrize("make", [WireMessage.of_text, WireMessage.of_bytes])
def test_a_directly_written_frame_is_what_uvicorn_would_send(
    make: Callable[[bytes], WireMessage], size: int
) -> None:
    message = make(b"x" * size)
    connection, sink = _open_connection()
    asked: Any = {"type": "websocket.send"}
    asked |= {"text": message.payload.decode()} if message.text else {"bytes": message.payload}
    with pytest.raises(StopIteration):  # while the transport takes data, `send` never waits
        connection.send(asked).send(None)
    public, sink.written = sink.written, b""
    assert DirectConnection(connection).write(message.wire)
    assert sink.written == public


class _Sink:
    """A transport that records the bytes written to it."""

    def __init__(self) -> None:
        self.written = b""

    def write(self, data: bytes) -> None:
        self.written += data

    def is_closing(self) -> bool:
        return False

    def get_write_buffer_size(self) -> int:
        return 0

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return default


def _open_connection() -> tuple[DirectProtocol, _Sink]:
    """uvicorn's protocol with an open WebSocket over a sink."""
    config = uvicorn.Config(
        lambda: None, interface="asgi3", log_config=None, ws_per_message_deflate=False
    )
    config.loaded, config.loaded_app = True, None  # it never runs an application
    loop = cast(asyncio.AbstractEventLoop, object())
    connection, sink = DirectProtocol(config, ServerState(), {}, _loop=loop), _Sink()
    connection.connection_made(cast(asyncio.Transport, sink))
    connection.handshake_complete = True
    connection.conn.state = State.OPEN
    return connection, sink
