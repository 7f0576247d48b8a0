"""An answer that is sent while it is made, and so may have to be left unfinished."""

import logging

from fastapi.responses import StreamingResponse
from starlette.types import Send

from app.errors import AppError

_log = logging.getLogger("plinko")


class StreamedAnswer(StreamingResponse):
    """Pieces of a body; where the next cannot be had, the connection is closed in the middle.

    Its status has been told by then, so that only a body without an end says that something is
    missing. The log says what.
    """

    async def stream_response(self, send: Send) -> None:
        """Send the pieces that there are."""
        try:
            await super().stream_response(send)
        except AppError as error:
            _log.warning("answer cut short", extra={"why": str(error)})
