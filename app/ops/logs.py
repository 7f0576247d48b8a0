"""What the server logs, and how: lines for people, or one JSON object a line for machines.

Events are logged as a short fixed message with what is particular about them in `extra`, so that
machines can count them: `log.info("room closed", extra={"room": id})`. Addresses are logged without
their query, and bodies, headers and tokens not at all.
"""

import asyncio
import logging
import sys
from datetime import UTC, datetime

import msgspec

_STANDARD = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName"}
_AT_WILL = (
    "Invalid UTF-8 sequence",
    "Invalid HTTP request",
    "Unsupported upgrade request",
    "ASGI callable returned without completing handshake",  # said of refused ones too
    "ASGI callable returned without completing response",  # the application has said why
)
_FOREIGN = ("uvicorn", "asyncio")  # their own information lines would show whole addresses


def configure(level: str, style: str) -> None:
    """Log to standard error from `level` on, in the style `text` or `json`."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonFormatter() if style == "json" else TextFormatter())
    handler.addFilter(_Quiet())
    root = logging.getLogger()
    root.handlers[:] = [handler]
    root.setLevel(logging.WARNING)
    logging.getLogger("plinko").setLevel(level.upper())
    for name in _FOREIGN:
        logging.getLogger(name).setLevel(max(logging.WARNING, logging.getLevelName(level.upper())))


class _Quiet(logging.Filter):
    """Drops what has been told already: by a close code, or by a line of its own.

    A stop that ends requests after their grace says in one line how many they were; where each of
    them was then is nobody's failure.
    """

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the record is worth a line."""
        error = record.exc_info[1] if record.exc_info else None
        ended = isinstance(error, asyncio.CancelledError)
        return not ended and not record.getMessage().startswith(_AT_WILL)


def particulars(record: logging.LogRecord) -> dict[str, object]:
    """What a record carries beside what every record does."""
    return {name: value for name, value in vars(record).items() if name not in _STANDARD}


class TextFormatter(logging.Formatter):
    """`time level message name=value …`."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(message)s")

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - logging's name
        """The line, with the particulars behind it."""
        extra = "".join(f" {name}={value}" for name, value in particulars(record).items())
        return super().formatMessage(record) + extra


class JsonFormatter(logging.Formatter):
    """One JSON object a line: time, level, logger, event, the particulars, the error if any."""

    def format(self, record: logging.LogRecord) -> str:
        """The record as a line."""
        line: dict[str, object] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "event": record.getMessage(),
            **particulars(record),
        }
        if record.exc_info:
            line["error"] = self.formatException(record.exc_info)
        return msgspec.json.encode(line, enc_hook=str).decode()
