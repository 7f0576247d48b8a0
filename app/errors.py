"""The server's error tree, and the one place where HTTP statuses and close codes are assigned.

AppError                  `code` is its stable slug, `field` names the bad value's place
├── SettingError          a setting that cannot be used (start-up only)
├── MalformedError        a message of no known shape
│   ├── UnknownMessageError
│   ├── MediaTypeError    a body that says it is something else than JSON
│   └── HeadError         no HTTP request
├── InvalidValueError     well-formed, but a value is out of range
│   └── CostError          it costs more than any one request may
│       └── DeadlineError   it did, and was ended
├── NotFoundError
│   ├── UnknownBoardError
│   ├── UnknownRoomError
│   ├── UnknownSessionError  no player's session has this id, or it was not joined here
│   ├── MissingBallError   it may have landed or been taken out meanwhile
│   └── ClosedRoomError    it was there, and its creator closed it
├── SessionStateError     a player's session that cannot do this now: not open yet, or over
├── HaltedError           an operator has halted the room: it takes nothing new
├── RepeatedError         a key that was used before, where only a log can say for what
├── ResetError            a drop that a room's creator took back by resetting the room
├── OriginError           a page of another site asked
├── HostError             asked under a name that is not this server's
├── TooLateError          a request that does not arrive
├── TooLargeError         a body or a message over its limit
│   └── HeadTooLargeError
├── LimitError            a limit was reached; `retry_after` seconds when waiting helps
│   ├── RateLimitError
│   │   └── MessageFloodError
│   ├── BallLimitError
│   ├── ConnectionLimitError
│   ├── RoomFullError
│   ├── QuotaError
│   ├── ReadersError       one client reads as many logs at a time as it may
│   ├── BudgetError        this address has had computed what it may for now
│   └── RoomLimitError
├── BusyError             the server cannot take more work now
│   └── RebuildingError    the room is on its way back from the ledger
├── EndedError            the process that computed it ended by itself
├── GoneError             who asked has left before there was an answer
├── MissingPartError      a part of the program that is not installed here
├── LedgerError           what must be kept cannot be written or read now
│   ├── DamagedRoomError   what the ledger has of one room contradicts itself
│   └── LeaseLostError     another server has the room now
├── UndecidedError        what the ledger was given may be in it; what became of it is told later
├── TokenError            only the creator of a room may do this
│   └── NoTokenError      and no token was shown
├── AbuseError            a client that goes on sending what it was told not to
└── SlowClientError       a client that does not read what it is sent

Errors of the engine (`engine.errors`) pass through unchanged and are assigned here beside these.
"""

from collections.abc import Awaitable
from dataclasses import dataclass
from typing import Any

from engine.errors import (
    BoardError,
    EffortError,
    EngineError,
    JsonSyntaxError,
    JsonValueError,
    ParameterError,
    RecordError,
    SeedError,
)


class AppError(Exception):
    """Root of the server's errors; the message names the bad value and what would be right."""

    def __init__(self, message: str, *, field: str = "", retry_after: float | None = None) -> None:
        super().__init__(message)
        self.field = field
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
    """What was received is no HTTP request."""


class InvalidValueError(AppError):
    """A value out of its range or of the wrong type."""


class CostError(InvalidValueError):
    """What a request asks for costs more than one request may."""


class DeadlineError(CostError):
    """What was asked took longer than it may."""


class NotFoundError(AppError):
    """Something asked for by name that is not there."""


class UnknownBoardError(NotFoundError):
    """No preset and no registered board has this name or digest."""


class UnknownRoomError(NotFoundError):
    """No room has this id."""


class UnknownSessionError(NotFoundError):
    """No player's session has this id, or this connection has not joined it."""


class SessionStateError(AppError):
    """A player's session cannot do this now: it is not open yet, over, or of another table."""


class MissingBallError(NotFoundError):
    """The room has no such ball, or no more."""


class ClosedRoomError(NotFoundError):
    """The room's creator closed it."""


class HaltedError(AppError):
    """The room takes nothing new until who runs the server lets it go on."""


class RepeatedError(AppError):
    """A request with the key of another one, of which only a log can tell what came."""


class ResetError(AppError):
    """The room began anew while the drop was in flight; it has no result."""


class OriginError(AppError):
    """A request from a page of a site that is neither this one nor an allowed one."""


class HostError(AppError):
    """A request for a host that this server was not told it is."""


class TooLateError(AppError):
    """A request did not arrive in time."""


class TooLargeError(AppError):
    """A body or a message over its limit."""


class HeadTooLargeError(TooLargeError):
    """A request's head is over its limit."""


class LimitError(AppError):
    """A limit was reached."""


class RateLimitError(LimitError):
    """Too many drops or messages a second."""


class MessageFloodError(RateLimitError):
    """More messages a second than any player sends."""


class BallLimitError(LimitError):
    """The room holds as many balls as it may."""


class ConnectionLimitError(LimitError):
    """One client has as many connections as it may."""


class RoomFullError(LimitError):
    """The room has as many clients as it may."""


class QuotaError(LimitError):
    """One client has as many rooms as it may."""


class BudgetError(LimitError):
    """One client has had computed what it may for now."""


class ReadersError(LimitError):
    """One client reads as many logs of rooms at a time as it may."""


class RoomLimitError(LimitError):
    """The server holds as many rooms as it may, all in use."""


class BusyError(AppError):
    """The queue for heavy work is full."""


class RebuildingError(BusyError):
    """The room is on its way back from the ledger, and that takes longer than one waits."""


class EndedError(AppError):
    """A worker's process ended before it had an answer."""


class GoneError(AppError):
    """Who asked has left; nobody reads the answer."""


class MissingPartError(AppError):
    """Something asked for that needs a library which this server was installed without."""


class LedgerError(AppError):
    """The ledger cannot be written or read now; nothing of what was asked has been done."""


class UndecidedError(AppError):
    """It is not known yet whether what was asked has been done; it is neither refused nor lost.

    `outcome`: where somebody may wait on for what comes of it.
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
    """What the ledger has of one room is not whole, or contradicts itself; others are sound."""


class LeaseLostError(LedgerError):
    """The room is another server's by now: nothing of what was asked has been done here.

    `holder` is that server's name in the ledger, where it is known.
    """

    def __init__(self, message: str, *, field: str = "", holder: str = "") -> None:
        super().__init__(message, field=field)
        self.holder = holder


class TokenError(AppError):
    """A token that does not open this room, or a room that nobody may change."""


class NoTokenError(TokenError):
    """A request that needs a room's token shows none."""


class AbuseError(AppError):
    """Too many bad messages from one client."""


class SlowClientError(AppError):
    """A client that did not read for longer than the grace period, or fell too far behind."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What an error becomes outside: an HTTP status and title, an event code, a close code."""

    status: int
    code: str
    title: str
    close: int = 1008


# Close codes below 4000 are RFC 6455's; 4004 and 4008 are ours, after HTTP's 404 and 408, because
# no standard code tells a page 'do not come back' and 'come back, you were too slow'.
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
    SessionStateError: Answer(409, "session-state", "Not in this state of the session"),
    MissingBallError: Answer(404, "no-such-ball", "No such ball"),
    ClosedRoomError: Answer(404, "room-closed", "The room was closed", 4004),
    HaltedError: Answer(409, "room-halted", "The room is halted"),
    RepeatedError: Answer(409, "repeated", "Done before"),
    ResetError: Answer(409, "room-reset", "The room was reset"),
    OriginError: Answer(403, "foreign-origin", "Foreign origin"),
    HostError: Answer(421, "unknown-host", "Not this server's host"),
    HeadError: Answer(400, "not-http", "Not an HTTP request"),
    HeadTooLargeError: Answer(431, "head-too-large", "The request's head is too large"),
    TooLateError: Answer(408, "too-late", "The request did not arrive in time"),
    ConnectionLimitError: Answer(429, "too-many-connections", "Too many connections"),
    TooLargeError: Answer(413, "too-large", "Too large", 1009),
    LimitError: Answer(429, "limit-reached", "Limit reached", 1013),
    RateLimitError: Answer(429, "rate-limited", "Too many requests"),
    MessageFloodError: Answer(429, "too-many-messages", "Too many messages"),
    BallLimitError: Answer(429, "too-many-balls", "Too many balls in the room", 1013),
    RoomFullError: Answer(429, "room-full", "The room is full", 1013),
    QuotaError: Answer(429, "room-quota", "Too many rooms of one client", 1013),
    ReadersError: Answer(429, "too-many-logs", "Too many logs read at a time"),
    BudgetError: Answer(429, "budget-spent", "Too much to compute for one client"),
    RoomLimitError: Answer(429, "too-many-rooms", "Too many rooms", 1013),
    BusyError: Answer(503, "busy", "The server is busy", 1013),
    RebuildingError: Answer(503, "room-rebuilding", "The room is being rebuilt", 1013),
    EndedError: Answer(503, "worker-ended", "A worker ended", 1013),
    GoneError: Answer(499, "client-gone", "The client has left"),
    MissingPartError: Answer(501, "not-installed", "Not installed on this server"),
    LedgerError: Answer(503, "ledger-unavailable", "The ledger cannot be reached", 1013),
    UndecidedError: Answer(503, "undecided", "Not decided yet", 1013),
    DamagedRoomError: Answer(503, "room-damaged", "The room is set aside", 1013),
    LeaseLostError: Answer(503, "room-moved", "The room is at another server", 1012),
    TokenError: Answer(403, "not-yours", "Not your room"),
    NoTokenError: Answer(401, "token-missing", "A room's token is missing"),
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

RETRY_AFTER = 1.0  # seconds; what 429 and 503 suggest when the error knows nothing better


def answer(error: BaseException) -> Answer:
    """The `Answer` assigned to the nearest class of `error`; a plain 500 for a stranger."""
    for kind in type(error).__mro__:
        if kind in ANSWERS:
            return ANSWERS[kind]
    return ANSWERS[AppError]


def retry_after(error: Exception) -> int | None:
    """Whole seconds after which trying again makes sense, or None when it does not."""
    if answer(error).status not in (429, 503):
        return None
    seconds = error.retry_after if isinstance(error, AppError) else None
    return max(1, int(-(-(RETRY_AFTER if seconds is None else seconds) // 1)))


_LEDGER_SECRET = "the ledger cannot be used now, and nothing was done; the server's log says why"
_DAMAGED_SECRET = (
    "the room is set aside, as what the ledger has of it is damaged; whoever runs the server can "
    "mend it"
)
_MOVED = "the room is at another server now; ask again, and you are brought there"


def told(error: BaseException) -> str:
    """What a client may read of an error.

    What a database says is not for it: that has file names, addresses and the tables' insides.
    Nor is what a stranger says.
    """
    if isinstance(error, DamagedRoomError):
        return _DAMAGED_SECRET
    if isinstance(error, LeaseLostError):
        return _MOVED
    if isinstance(error, LedgerError):
        return _LEDGER_SECRET
    if isinstance(error, AppError | EngineError):
        return str(error)
    return "An error of the server's own, which it has logged."


def shorten(value: object, limit: int = 40) -> str:
    """`repr` for an error's message, cut so that a huge value does not make a huge message."""
    try:
        shown = repr(value)
    except ValueError:  # an integer of more digits than Python prints
        shown = "an integer of thousands of digits"
    return shown if len(shown) <= limit else shown[: limit - 3] + "..."
