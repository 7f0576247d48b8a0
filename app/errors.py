"""The server's error tree, and the one place where HTTP statuses and close codes are assigned.

AppError
├── SettingError          a setting that cannot be used (only at start)
├── MalformedError        a message of an unknown shape
│   ├── UnknownMessageError
│   ├── MediaTypeError    a body whose Content-Type is not JSON
│   └── HeadError         not an HTTP request
├── InvalidValueError     well-formed, but a value is out of range
│   └── CostError          the request costs more than a request may
│       └── DeadlineError   the work took too long and was cancelled
├── NotFoundError
│   ├── UnknownBoardError
│   ├── UnknownRoomError
│   ├── UnknownSessionError  no fair session has this id, or it was not joined here
│   ├── MissingBallError   the ball may have landed or been removed
│   └── ClosedRoomError    the room's owner has closed it
├── SessionStateError     a fair session that is not open yet, or has ended
├── HaltedError           an operator has halted the room: it refuses all inputs
├── RepeatedError         a key that was used before; only the room's log has the outcome
├── KeyReusedError        a key that was used before for another request
├── ResetError            the room's owner reset the room while the drop was in flight
├── OriginError           a request from another site's page
├── HostError             a request for a host that is not this server
├── TooLateError          a request that does not arrive in time
├── TooLargeError         a body or a message over its limit
│   └── HeadTooLargeError
├── LimitError            a limit was reached; `retry_after` is set if waiting helps
│   ├── RateLimitError
│   │   └── MessageFloodError
│   ├── BallLimitError
│   ├── ConnectionLimitError
│   ├── RoomFullError
│   ├── QuotaError
│   ├── ReadersError       a client reads too many logs at a time
│   ├── BudgetError        a client's address has used up its computing time
│   └── RoomLimitError
├── BusyError             the server cannot accept more work now
│   └── RebuildingError    touching balls are being replayed from the ledger
├── EndedError            the worker process ended unexpectedly
├── GoneError             the client has left before the response
├── LedgerError           the ledger cannot be written or read now
│   ├── DamagedRoomError   a room's record in the ledger contradicts itself
│   └── LeaseLostError     another server has the room now
├── UndecidedError        the ledger has not answered: the outcome is sent later
├── TokenError            a wrong token, or a room without an owner
│   └── NoTokenError       the token is missing
├── AbuseError            a client that keeps sending bad messages
└── SlowClientError       a client that does not read what it is sent

Errors of the engine (`plinko.engine.errors`) pass through unchanged; their answers are assigned
here too.
"""

from collections.abc import Awaitable
from dataclasses import dataclass
from typing import Any

from plinko.engine.errors import (
    BoardError,
    EffortError,
    EngineError,
    JsonSyntaxError,
    JsonValueError,
    MissingPartError,
    ParameterError,
    PlinkoError,
    RecordError,
    SeedError,
)


class AppError(PlinkoError):
    """Root of the server's errors. The message names the bad value and what would be right.

    `field` is the bad value's place; `retry_after` the seconds after which to try again.
    """

    def __init__(self, message: str, *, field: str = "", retry_after: float | None = None) -> None:
        super().__init__(message, field=field)
        self.retry_after = retry_after


class SettingError(AppError):
    """A setting that cannot be used."""


class MalformedError(AppError):
    """Not JSON, or JSON of the wrong shape."""


class UnknownMessageError(MalformedError):
    """A message whose `type` is not one of the protocol's."""


class MediaTypeError(MalformedError):
    """A body whose Content-Type is not JSON's."""


class HeadError(MalformedError):
    """The received bytes are not an HTTP request."""


class InvalidValueError(AppError, ValueError):
    """A value out of its range or of the wrong type."""


class CostError(InvalidValueError):
    """A request's work costs more than one request may."""


class DeadlineError(CostError):
    """A request's work took longer than it may."""


class NotFoundError(AppError):
    """Nothing has the requested name."""


class UnknownBoardError(NotFoundError):
    """No preset and no registered board has this name or digest."""


class UnknownRoomError(NotFoundError):
    """No room has this id."""


class UnknownSessionError(NotFoundError):
    """No fair session has this id, or this connection has not joined it."""


class SessionStateError(AppError):
    """The fair session is not open yet, has ended, or belongs to another room."""


class MissingBallError(NotFoundError):
    """The room has no such ball, or no longer has it."""


class ClosedRoomError(NotFoundError):
    """The room's owner has closed it."""


class HaltedError(AppError):
    """The room refuses all inputs until the operator resumes it."""


class RepeatedError(AppError):
    """A request with the key of an earlier one, whose outcome only the room's log has."""


class KeyReusedError(AppError):
    """The caller has used this idempotency key before, for another request."""


class ResetError(AppError):
    """The room was reset while the drop was in flight; the drop has no result."""


class OriginError(AppError):
    """A request from a page of a site that is neither this one nor an allowed one."""


class HostError(AppError):
    """A request for a host that is not one of this server's names."""


class TooLateError(AppError):
    """A request did not arrive in time."""


class TooLargeError(AppError):
    """A body or a message over its limit."""


class RangeError(AppError):
    """A part of a picture or film that it does not have."""


class HeadTooLargeError(TooLargeError):
    """A request's head is over its limit."""


class LimitError(AppError):
    """A limit was reached."""


class RateLimitError(LimitError):
    """Too many drops or messages a second."""


class MessageFloodError(RateLimitError):
    """More messages a second than any player sends."""


class BallLimitError(LimitError):
    """The room has as many balls as it may."""


class ConnectionLimitError(LimitError):
    """One client has as many connections as it may."""


class RoomFullError(LimitError):
    """The room has as many clients as it may."""


class QuotaError(LimitError):
    """One client has as many rooms as it may."""


class BudgetError(LimitError):
    """One client's address has used up its computing time for now."""


class ReadersError(LimitError):
    """One client reads as many room logs at a time as it may."""


class RoomLimitError(LimitError):
    """The server has as many rooms as it may, all in use."""


class BusyError(AppError):
    """The queue for heavy work is full."""


class RebuildingError(BusyError):
    """Touching balls are being replayed from the ledger, longer than a request waits."""


class EndedError(AppError):
    """A worker process ended before it had a result."""


class GoneError(AppError):
    """The client has left, so nobody reads the response."""


class LedgerError(AppError):
    """The ledger cannot be written or read now; the request had no effect."""


class UndecidedError(AppError):
    """The ledger has not answered in time: the request may have had its effect or may yet have it.

    `outcome`, if set, can be awaited for the final result.
    """

    def __init__(
        self,
        message: str,
        *,
        field: str = "",
        retry_after: float | None = None,
        outcome: Awaitable[Any] | None = None,
    ) -> None:
        super().__init__(message, field=field, retry_after=retry_after)
        self.outcome = outcome


class DamagedRoomError(LedgerError):
    """The record of one room is incomplete or contradicts itself; other rooms are not affected."""


class LeaseLostError(LedgerError):
    """Another server has the room now: the request had no effect here.

    `holder` is that server's name in the ledger, if it is known.
    """

    def __init__(self, message: str, *, field: str = "", holder: str = "") -> None:
        super().__init__(message, field=field)
        self.holder = holder


class TokenError(AppError):
    """The token is not the one that this request needs, or the room has no owner."""


class NoTokenError(TokenError):
    """The request needs a token and has none."""


class AbuseError(AppError):
    """Too many bad messages from one client."""


class SlowClientError(AppError):
    """A client that did not read for longer than the grace period, or fell too far behind."""


@dataclass(frozen=True, slots=True)
class Answer:
    """An error as clients see it: HTTP status and title, event code, WebSocket close code."""

    status: int
    code: str
    title: str
    close: int = 1008


# Close codes below 4000 are RFC 6455's. 4004 and 4008 are our own, after HTTP's 404 and 408: no
# standard code says 'do not reconnect' (4004) or 'you were too slow, reconnect' (4008).
ANSWERS: dict[type[Exception], Answer] = {
    AppError: Answer(500, "server-error", "The server failed", 1011),
    MalformedError: Answer(400, "malformed", "Malformed request", 1007),
    UnknownMessageError: Answer(400, "unknown-message", "Unknown message type"),
    MediaTypeError: Answer(415, "unsupported-media-type", "Unsupported media type"),
    InvalidValueError: Answer(422, "invalid-value", "Invalid value"),
    CostError: Answer(422, "too-expensive", "Too expensive"),
    DeadlineError: Answer(422, "too-long", "Took too long to compute"),
    NotFoundError: Answer(404, "not-found", "Not found", 4004),
    UnknownBoardError: Answer(404, "unknown-board", "Unknown board", 4004),
    UnknownRoomError: Answer(404, "unknown-room", "Unknown room", 4004),
    UnknownSessionError: Answer(404, "unknown-session", "Unknown session"),
    SessionStateError: Answer(409, "session-state", "Not possible in this state of the session"),
    MissingBallError: Answer(404, "no-such-ball", "No such ball"),
    ClosedRoomError: Answer(404, "room-closed", "The room was closed", 4004),
    HaltedError: Answer(409, "room-halted", "The room is halted"),
    RepeatedError: Answer(409, "repeated", "Already done"),
    KeyReusedError: Answer(422, "key-reused", "The key belongs to another request"),
    ResetError: Answer(409, "room-reset", "The room was reset"),
    OriginError: Answer(403, "foreign-origin", "Foreign origin"),
    HostError: Answer(421, "unknown-host", "Not this server's host"),
    HeadError: Answer(400, "not-http", "Not an HTTP request"),
    HeadTooLargeError: Answer(431, "head-too-large", "The request's head is too large"),
    TooLateError: Answer(408, "too-late", "The request did not arrive in time"),
    ConnectionLimitError: Answer(429, "too-many-connections", "Too many connections"),
    TooLargeError: Answer(413, "too-large", "Too large", 1009),
    RangeError: Answer(416, "no-such-range", "No such range"),
    LimitError: Answer(429, "limit-reached", "Limit reached", 1013),
    RateLimitError: Answer(429, "rate-limited", "Too many requests"),
    MessageFloodError: Answer(429, "too-many-messages", "Too many messages"),
    BallLimitError: Answer(429, "too-many-balls", "Too many balls in the room", 1013),
    RoomFullError: Answer(429, "room-full", "The room is full", 1013),
    QuotaError: Answer(429, "room-quota", "Too many rooms of one client", 1013),
    ReadersError: Answer(429, "too-many-logs", "Too many logs read at a time"),
    BudgetError: Answer(429, "budget-spent", "Computing time used up"),
    RoomLimitError: Answer(429, "too-many-rooms", "Too many rooms", 1013),
    BusyError: Answer(503, "busy", "The server is busy", 1013),
    RebuildingError: Answer(503, "room-rebuilding", "The room is being replayed", 1013),
    EndedError: Answer(503, "worker-ended", "A worker ended", 1013),
    GoneError: Answer(499, "client-gone", "The client has left"),
    MissingPartError: Answer(501, "not-installed", "Not installed on this server"),
    LedgerError: Answer(503, "ledger-unavailable", "The ledger cannot be reached", 1013),
    UndecidedError: Answer(503, "undecided", "Not decided yet", 1013),
    DamagedRoomError: Answer(503, "room-damaged", "The room's record is damaged", 1013),
    LeaseLostError: Answer(503, "room-moved", "Another server has the room", 1012),
    TokenError: Answer(403, "not-yours", "Not your room"),
    NoTokenError: Answer(401, "token-missing", "The token is missing"),
    AbuseError: Answer(429, "abuse", "Too many bad messages"),
    SlowClientError: Answer(408, "too-slow", "The client is too slow", 4008),
    EngineError: Answer(422, "invalid-value", "Invalid value"),
    BoardError: Answer(422, "bad-board", "The board cannot be played"),
    EffortError: Answer(422, "too-much-work", "Takes too much computing"),
    SeedError: Answer(422, "bad-seed", "Invalid seed"),
    ParameterError: Answer(422, "bad-parameter", "Invalid parameter"),
    RecordError: Answer(422, "bad-record", "Malformed drop record"),
    JsonSyntaxError: Answer(400, "malformed", "Malformed request", 1007),
    JsonValueError: Answer(422, "invalid-value", "Invalid value"),
}

RETRY_AFTER = 1.0  # s; sent with 429 and 503 if the error has no `retry_after`


def answer(error: BaseException) -> Answer:
    """The `Answer` for the nearest class of `error`; a plain 500 for a foreign exception."""
    for kind in type(error).__mro__:
        if kind in ANSWERS:
            return ANSWERS[kind]
    return ANSWERS[AppError]


def retry_after(error: Exception) -> int | None:
    """Whole seconds after which to try again; None if trying again does not help."""
    if answer(error).status not in (429, 503):
        return None
    seconds = error.retry_after if isinstance(error, AppError) else None
    return max(1, int(-(-(RETRY_AFTER if seconds is None else seconds) // 1)))


_LEDGER_SECRET = (
    "the ledger is not available now, and nothing was done; try again later (the server's log has "
    "the reason)"
)
_DAMAGED_SECRET = (
    "the room cannot open because its record in the ledger is damaged; the server's operator can "
    "repair it"
)
_MOVED = "another server has the room now; try again, and you will reach the room there"


def told(error: BaseException) -> str:
    """The message of an error for clients.

    A database's own message stays in the log: it has file names, addresses and database tables. So
    does the message of a foreign exception.
    """
    if isinstance(error, DamagedRoomError):
        return _DAMAGED_SECRET
    if isinstance(error, LeaseLostError):
        return _MOVED
    if isinstance(error, LedgerError):
        return _LEDGER_SECRET
    if isinstance(error, PlinkoError):
        return str(error)
    return "The server failed; its log has the reason."


def shorten(value: object, limit: int = 40) -> str:
    """`repr` for an error's message, cut so that a huge value does not make a huge message."""
    try:
        shown = repr(value)
    except ValueError:  # an integer of more digits than Python prints
        shown = "an integer of thousands of digits"
    return shown if len(shown) <= limit else shown[: limit - 3] + "..."
