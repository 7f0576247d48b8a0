"""The server's errors, each with the response that its client gets.

The message names the bad value and says what would be right. Errors of the engine
(`plinko.engine.errors`) pass through unchanged; their responses are below.
"""

from collections.abc import Awaitable
from typing import Any, ClassVar, Final, NamedTuple

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


class ErrorResponse(NamedTuple):
    """An error as clients see it.

    status and title: of the HTTP response. code: of the event and the problem. close: of the
    WebSocket. text: sent in place of the error's message, which has private details.

    Close codes below 4000 are RFC 6455's. 4004 and 4008 are our own, after HTTP's 404 and 408: no
    standard code says 'do not reconnect' (4004) or 'you were too slow, reconnect' (4008).
    """

    status: int
    code: str
    title: str
    close: int = 1008
    text: str | None = None


class AppError(PlinkoError):
    """Root of the server's errors. The message names the bad value and what would be right.

    `field` is the bad value's place; `retry_after` the seconds after which to try again.
    """

    response: ClassVar[ErrorResponse] = ErrorResponse(
        500, "server-error", "The server failed", 1011
    )

    def __init__(self, message: str, *, field: str = "", retry_after: float | None = None) -> None:
        super().__init__(message, field=field)
        self.retry_after = retry_after


class SettingError(AppError):
    """A setting that cannot be used."""


class StartError(SettingError):
    """The server cannot start now, but may later with the same settings."""


class MalformedError(AppError):
    response = ErrorResponse(400, "malformed", "Malformed request", 1007)


class UnknownMessageError(MalformedError):
    response = ErrorResponse(400, "unknown-message", "Unknown message type")


class MediaTypeError(MalformedError):
    response = ErrorResponse(415, "unsupported-media-type", "Unsupported media type")


class HeadError(MalformedError):
    response = ErrorResponse(400, "not-http", "Not an HTTP request")


class InvalidValueError(AppError, ValueError):
    response = ErrorResponse(422, "invalid-value", "Invalid value")


class CostError(InvalidValueError):
    response = ErrorResponse(422, "too-expensive", "Too expensive")


class DeadlineError(CostError):
    """A request's work took longer than it may."""

    response = ErrorResponse(422, "too-long", "Took too long to compute")


class NotFoundError(AppError):
    response = ErrorResponse(404, "not-found", "Not found", 4004)


class UnknownBoardError(NotFoundError):
    """No preset and no registered board has this name or digest."""

    response = ErrorResponse(404, "unknown-board", "Unknown board", 4004)


class UnknownRoomError(NotFoundError):
    response = ErrorResponse(404, "unknown-room", "Unknown room", 4004)


class UnknownSessionError(NotFoundError):
    """No fair session has this id, or this connection has not joined it."""

    response = ErrorResponse(404, "unknown-session", "Unknown session")


class SessionStateError(AppError):
    """The fair session is not open yet, has ended, or belongs to another room."""

    response = ErrorResponse(409, "session-state", "Not possible in this state of the session")


class MissingBallError(NotFoundError):
    response = ErrorResponse(404, "no-such-ball", "No such ball")


class ClosedRoomError(NotFoundError):
    response = ErrorResponse(404, "room-closed", "The room was closed", 4004)


class HaltedError(AppError):
    """The room refuses all inputs until the operator resumes it."""

    response = ErrorResponse(409, "room-halted", "The room is halted")


class BannedError(AppError):
    """The operator has banned the client's address or `who` for a time."""

    response = ErrorResponse(403, "banned", "Banned for a time", 4004)


class RepeatedError(AppError):
    """A request with the key of an earlier one, whose outcome only the room's log has."""

    response = ErrorResponse(409, "repeated", "Already done")


class KeyReusedError(AppError):
    """The caller has used this idempotency key before, for another request."""

    response = ErrorResponse(422, "key-reused", "The key belongs to another request")


class ResetError(AppError):
    """The room was reset while the drop was in flight; the drop has no result."""

    response = ErrorResponse(409, "room-reset", "The room was reset")


class OriginError(AppError):
    """A request from a page of a site that is neither this one nor an allowed one."""

    response = ErrorResponse(403, "foreign-origin", "Foreign origin")


class HostError(AppError):
    """A request for a host that is not one of this server's names."""

    response = ErrorResponse(421, "unknown-host", "Not this server's host")


class TooLateError(AppError):
    response = ErrorResponse(408, "too-late", "The request did not arrive in time")


class TooLargeError(AppError):
    response = ErrorResponse(413, "too-large", "Too large", 1009)


class RangeError(AppError):
    response = ErrorResponse(416, "no-such-range", "No such range")


class HeadTooLargeError(TooLargeError):
    response = ErrorResponse(431, "head-too-large", "The request's head is too large")


class LimitError(AppError):
    response = ErrorResponse(429, "limit-reached", "Limit reached", 1013)


class RateLimitError(LimitError):
    response = ErrorResponse(429, "rate-limited", "Too many requests")


class MessageFloodError(RateLimitError):
    """More messages a second than any player sends."""

    response = ErrorResponse(429, "too-many-messages", "Too many messages")


class BallLimitError(LimitError):
    response = ErrorResponse(429, "too-many-balls", "Too many balls in the room", 1013)


class ConnectionLimitError(LimitError):
    response = ErrorResponse(429, "too-many-connections", "Too many connections")


class RoomFullError(LimitError):
    response = ErrorResponse(429, "room-full", "The room is full", 1013)


class QuotaError(LimitError):
    response = ErrorResponse(429, "room-quota", "Too many rooms of one client", 1013)


class BudgetError(LimitError):
    """One client's address has used up its computing time for now."""

    response = ErrorResponse(429, "budget-spent", "Computing time used up")


class ReadersError(LimitError):
    response = ErrorResponse(429, "too-many-logs", "Too many logs read at a time")


class RoomLimitError(LimitError):
    response = ErrorResponse(429, "too-many-rooms", "Too many rooms", 1013)


class BusyError(AppError):
    """The queue for heavy work is full."""

    response = ErrorResponse(503, "busy", "The server is busy", 1013)


class RebuildingError(BusyError):
    """Touching balls are being replayed from the ledger, longer than a request waits."""

    response = ErrorResponse(503, "room-rebuilding", "The room is being replayed", 1013)


class EndedError(AppError):
    """A worker process ended before it had a result."""

    response = ErrorResponse(503, "worker-ended", "A worker ended", 1013)


class GoneError(AppError):
    """The client has left, so nobody reads the response."""

    response = ErrorResponse(499, "client-gone", "The client has left")


class LedgerError(AppError):
    """The ledger cannot be written or read now; the request had no effect."""

    response = ErrorResponse(
        503,
        "ledger-unavailable",
        "The ledger cannot be reached",
        1013,
        "the ledger is not available now, and nothing was done; try again later (the server's log "
        "has the reason)",
    )


class LedgerInUseError(LedgerError):
    """Another server uses the ledger."""


class UndecidedError(AppError):
    """The ledger has not answered in time: the request may have had its effect or may yet have it.

    `outcome`, if set, can be awaited for the final result.
    """

    response = ErrorResponse(503, "undecided", "Not decided yet", 1013)

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

    response = ErrorResponse(
        503,
        "room-damaged",
        "The room's record is damaged",
        1013,
        "the room cannot open because its record in the ledger is damaged; the server's operator "
        "can repair it",
    )


class PrunedError(LedgerError):
    """The drops are older than the server keeps them, and were deleted."""

    response = ErrorResponse(410, "pruned", "Older than the server keeps drops")


class LeaseLostError(LedgerError):
    """Another server has the room now: the request had no effect here.

    `holder` is that server's name in the ledger, if it is known.
    """

    response = ErrorResponse(
        503,
        "room-moved",
        "Another server has the room",
        1012,
        "another server has the room now; try again, and you will reach the room there",
    )

    def __init__(self, message: str, *, field: str = "", holder: str = "") -> None:
        super().__init__(message, field=field)
        self.holder = holder


class TokenError(AppError):
    response = ErrorResponse(403, "not-yours", "Not your room")


class NoTokenError(TokenError):
    """The request needs a token and has none."""

    response = ErrorResponse(401, "token-missing", "The token is missing")


class AbuseError(AppError):
    response = ErrorResponse(429, "abuse", "Too many bad messages")


class SlowClientError(AppError):
    """A client that did not read for longer than the grace period, or fell too far behind."""

    response = ErrorResponse(408, "too-slow", "The client is too slow", 4008)


_OF_ENGINE: Final[dict[type[BaseException], ErrorResponse]] = {
    MissingPartError: ErrorResponse(501, "not-installed", "Not installed on this server"),
    EngineError: ErrorResponse(422, "invalid-value", "Invalid value"),
    BoardError: ErrorResponse(422, "bad-board", "The board cannot be played"),
    EffortError: ErrorResponse(422, "too-much-work", "Takes too much computing"),
    SeedError: ErrorResponse(422, "bad-seed", "Invalid seed"),
    ParameterError: ErrorResponse(422, "bad-parameter", "Invalid parameter"),
    RecordError: ErrorResponse(422, "bad-record", "Malformed drop record"),
    JsonSyntaxError: ErrorResponse(400, "malformed", "Malformed request", 1007),
    JsonValueError: ErrorResponse(422, "invalid-value", "Invalid value"),
}

RETRY_AFTER = 1.0  # s; sent with 429 and 503 if the error has no `retry_after`


def response_for(error: BaseException) -> ErrorResponse:
    """The response to an error; a plain 500 to a foreign exception."""
    if isinstance(error, AppError):
        return error.response
    found = (_OF_ENGINE[kind] for kind in type(error).__mro__ if kind in _OF_ENGINE)
    return next(found, AppError.response)


def retry_after(error: Exception) -> int | None:
    """Whole seconds after which to try again; None if trying again does not help."""
    if response_for(error).status not in (429, 503):
        return None
    seconds = error.retry_after if isinstance(error, AppError) else None
    return max(1, int(-(-(RETRY_AFTER if seconds is None else seconds) // 1)))


def public_text(error: BaseException) -> str:
    """The message of an error for clients.

    A database's own message stays in the log: it has file names, addresses and database tables. So
    does the message of a foreign exception.
    """
    if isinstance(error, PlinkoError):
        return response_for(error).text or str(error)
    return "The server failed; its log has the reason."
