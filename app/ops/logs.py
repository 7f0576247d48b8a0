"""The format of log lines: text for people, or one JSON object per line for machines.

An event is logged as a short fixed message, which machines can count, with its details in `extra`:
`log.info("room closed", extra={"room": id})`. URLs are logged without their query. Bodies, headers
and tokens are never logged.
"""

import asyncio
import logging
import sys
import threading
from datetime import UTC, datetime

import msgspec

_STANDARD = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName"}
_AT_WILL = (
    "Invalid UTF-8 sequence",
    "Invalid HTTP request",
    "Unsupported upgrade request",
    "ASGI callable returned without completing handshake",  # also logged for refused ones
    "ASGI callable returned without completing response",  # the application has logged why
)
"""Beginnings of messages that any client can provoke at will."""

_FOREIGN = ("uvicorn", "asyncio")  # their lines below WARNING would contain complete URLs


def configure(level: str, style: str) -> None:
    """Log to stderr from `level` on, in the style `text` or `json`.

    As JSON also Python's warnings and tracebacks, so that every line is an object.
    """
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonFormatter() if style == "json" else TextFormatter())
    handler.addFilter(_Quiet())
    root = logging.getLogger()
    root.handlers[:] = [handler]
    root.setLevel(logging.WARNING)
    logging.getLogger("plinko").setLevel(level.upper())
    for name in _FOREIGN:
        logging.getLogger(name).setLevel(max(logging.WARNING, logging.getLevelName(level.upper())))
    if style == "json":
        logging.captureWarnings(True)
        sys.excepthook = lambda _, error, __: _uncaught("the process ends by a fault", error)
        threading.excepthook = lambda args: _uncaught("a thread ends by a fault", args.exc_value)
        sys.unraisablehook = lambda args: _uncaught("a fault was passed over", args.exc_value)


def in_json() -> bool:
    """Whether the log of this process is JSON."""
    return any(isinstance(each.formatter, JsonFormatter) for each in logging.root.handlers)


def json_line(event: str, **about: object) -> str:
    """The line of an event that is not logged but printed."""
    record = logging.makeLogRecord({"name": "plinko", "levelname": "INFO", "msg": event, **about})
    return JsonFormatter().format(record)


def _uncaught(event: str, error: BaseException | None) -> None:
    logging.getLogger("plinko").critical(event, exc_info=error)


class _Quiet(logging.Filter):
    """Drops records that are already reported by a close code or by another line.

    When shutdown cancels requests after the grace period, one line says how many there were. A
    traceback of each cancelled request would only be noise.
    """

    def filter(self, record: logging.LogRecord) -> bool:
        error = record.exc_info[1] if record.exc_info else None
        ended = isinstance(error, asyncio.CancelledError)
        return not ended and not record.getMessage().startswith(_AT_WILL)


def particulars(record: logging.LogRecord) -> dict[str, object]:
    """The fields that the caller gave in `extra`."""
    return {name: value for name, value in vars(record).items() if name not in _STANDARD}


class TextFormatter(logging.Formatter):
    """Formats a record as `time level message name=value …`."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(message)s")

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - logging's name
        extra = "".join(f" {name}={value}" for name, value in particulars(record).items())
        return super().formatMessage(record) + extra


class JsonFormatter(logging.Formatter):
    """Formats a record as a JSON object: time, level, logger, event, particulars, error if any."""

    def format(self, record: logging.LogRecord) -> str:
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
