"""Frames written straight to the transport: the same bytes as uvicorn's own, or not used at all."""

import logging

import pytest
from hypothesis import given
from hypothesis import strategies as st
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame as ReferenceFrame
from websockets.frames import Opcode

from app.errors import SettingError
from app.live.broadcast import transport
from app.protocol.wire import WireMessage
from engine import Board, drop
from tests.app.conftest import playing, serving


@given(st.binary(max_size=300) | st.sampled_from([bytes(65535), bytes(65536)]))
def test_a_frame_is_what_the_websockets_library_makes_of_it(payload: bytes) -> None:
    for frame, opcode in (
        (WireMessage.of_text(payload), Opcode.TEXT),
        (WireMessage.of_bytes(payload), Opcode.BINARY),
    ):
        assert frame.wire == ReferenceFrame(opcode, payload).serialize(mask=False)


def test_writing_directly_works_with_the_installed_uvicorn() -> None:
    assert transport.self_test() is None
    assert transport.choose("auto") == "direct"
    assert transport.choose("public") == "public"


@pytest.mark.parametrize("missing", ["transport", "close_sent"])
def test_a_uvicorn_that_changed_inside_is_served_through_public_calls(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, missing: str
) -> None:
    made = transport.DirectProtocol.connection_made

    def renamed(connection: transport.DirectProtocol, sink: object) -> None:
        made(connection, sink)  # type: ignore[arg-type]
        connection.__dict__.pop(missing)

    monkeypatch.setattr(transport.DirectProtocol, "connection_made", renamed)
    fault = transport.self_test()
    assert fault is not None
    assert missing in fault
    with caplog.at_level(logging.WARNING):
        assert transport.choose("auto") == "public"
    assert missing in caplog.text
    with pytest.raises(SettingError, match=missing):
        transport.choose("direct")


def test_other_bytes_than_uvicorns_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.protocol.wire._BINARY", 0x81)
    assert transport.self_test() == "a binary frame of 0 bytes comes out differently"


@pytest.mark.parametrize("kind", ["direct", "public"])
async def test_a_game_is_the_same_over_either_kind(kind: str) -> None:
    with serving(transport=kind) as server:
        assert server.services.transport == kind
        async with playing(server.socket("triangle-8")) as player:
            await player.send(type="drop", seed=42)
            landed = await player.until("landed")
            await player.until_empty()
    assert landed["digest"] == drop(Board.preset("triangle-8"), 42).digest
    ticks = [player.decode(frame).tick for frame in player.binaries]
    assert ticks == sorted(set(ticks))
    assert len(ticks) > 60


@pytest.mark.parametrize("kind", ["direct", "public"])
def test_the_kind_is_what_uvicorn_speaks_with(kind: str) -> None:
    assert issubclass(transport.protocol_class(kind), WebSocketsSansIOProtocol)
    assert (transport.protocol_class(kind) is transport.DirectProtocol) == (kind == "direct")
