"""Who may change a room or drop in a session: tokens, and where the server's secrets are kept."""

import base64
import hashlib
import hmac
import os
import secrets
import tempfile
from pathlib import Path

from plinko.app.errors import NoTokenError, SettingError, TokenError

_BYTES = 32


class Tokens:
    """Signs and checks the tokens of rooms' creators. Nothing about a token is stored.

    `kind` is part of what is signed, so that a token for one kind of thing opens no other.
    """

    def __init__(self, secret: bytes, kind: str = "room") -> None:
        self._secret = secret
        self._kind = kind

    def of(self, room_id: str) -> str:
        """The token of this id: its HMAC-SHA256 in base64 for URLs, 43 characters."""
        purpose = f"plinko {self._kind} ".encode()
        signature = hmac.digest(self._secret, purpose + room_id.encode(), hashlib.sha256)
        return base64.urlsafe_b64encode(signature).rstrip(b"=").decode()

    @property
    def mark(self) -> str:
        """Tells this secret from others without revealing it: 64 hexadecimal digits."""
        return hmac.digest(self._secret, b"plinko mark of the secret", hashlib.sha256).hex()

    def mark_of(self, address: str) -> str:
        """A creator's mark: always the same for one address, but it does not reveal the address."""
        return self.of(f"creator {address}")

    def check(self, room_id: str, authorization: str | None) -> None:
        """Raise unless an Authorization header has the token of this id; in constant time.

        Raises NoTokenError if it has none, TokenError if it has another token. Neither message
        contains the token that was sent.
        """
        self.check_shown(room_id, bearer_of(authorization))

    def check_shown(self, room_id: str, shown: str | None) -> None:
        """Like `check`, for a token that did not come in a header; None if no token came."""
        if shown is None:
            raise NoTokenError(
                f"{self._kind} {room_id!r} needs the token that its creator received, sent as "
                "`Authorization: Bearer TOKEN`",
                field="authorization",
            )
        if not hmac.compare_digest(shown.encode(), self.of(room_id).encode()):
            raise TokenError(
                f"the token is not that of {self._kind} {room_id!r}", field="authorization"
            )


class SessionTokens(Tokens):
    """The tokens of players' fair sessions.

    A session that a room's owner begins in that room has a token of another kind. It also carries
    the owner's right to name balls: a request has only one header for tokens, and could not send
    both.
    """

    def __init__(self, secret: bytes) -> None:
        super().__init__(secret, "session")
        self._owners = Tokens(secret, "session of an owner")

    def of_owner(self, session_id: str) -> str:
        """The token of a session begun by the room's owner."""
        return self._owners.of(session_id)

    def is_owners(self, session_id: str, authorization: str | None) -> bool:
        """Whether an Authorization header has the token of `of_owner`; in constant time."""
        return self._is_owners(session_id, bearer_of(authorization))

    def _is_owners(self, session_id: str, shown: str | None) -> bool:
        wanted = self._owners.of(session_id).encode()
        return shown is not None and hmac.compare_digest(shown.encode(), wanted)

    def check_shown(self, room_id: str, shown: str | None) -> None:
        """As in `Tokens`; the owner's token is valid too."""
        if not self._is_owners(room_id, shown):
            super().check_shown(room_id, shown)


def check_bearer(authorization: str | None, token: str, whose: str) -> None:
    """Raise NoTokenError or TokenError unless an Authorization header has this token.

    In constant time. `whose` goes into the message: 'of the operator'.
    """
    shown = bearer_of(authorization)
    if shown is None:
        raise NoTokenError(
            f"this needs the token {whose}, sent as `Authorization: Bearer TOKEN`",
            field="authorization",
        )
    if not hmac.compare_digest(shown.encode(), token.encode()):
        raise TokenError(f"the token is not that {whose}", field="authorization")


def bearer_of(authorization: str | None) -> str | None:
    """The bearer token in an Authorization header, if it has one."""
    scheme, _, shown = (authorization or "").partition(" ")
    return shown.strip() or None if scheme.lower() == "bearer" else None


def secret_of(given: str, file: Path | None) -> bytes:
    """The server's secret: `given`, or the content of `file`, which is created if missing.

    Without either, the secret is random and lives as long as the process. Only the file's owner may
    read it. Raises SettingError if the file cannot be read or created, or is too short.
    """
    if given:
        return given.encode()
    if file is None:
        return secrets.token_bytes(_BYTES)
    try:
        file.parent.mkdir(0o700, parents=True, exist_ok=True)
        _make(file)
        found = file.read_bytes().strip()
    except OSError as error:
        raise SettingError(
            f"cannot read or create the secret in {file}: {error.strerror or error}", field="data"
        ) from error
    if len(found) < _BYTES:
        raise SettingError(
            f"the secret in {file} has {len(found)} characters, fewer than {_BYTES}; delete the "
            "file, and the server creates a new one, with which no earlier token is valid",
            field="data",
        )
    return found


def _make(file: Path) -> None:
    """Write a new secret unless there is one, atomically even if several processes try it."""
    if file.exists():
        return
    # mkstemp: only the owner may read it, and the name is new.
    descriptor, draft = tempfile.mkstemp(prefix=f"{file.name}.", dir=file.parent)
    try:
        with os.fdopen(descriptor, "w") as out:
            out.write(secrets.token_hex(_BYTES) + "\n")
            out.flush()
            os.fsync(out.fileno())
        # Unlike a rename, a link does not replace the file of a faster process.
        os.link(draft, file)
    except FileExistsError:
        return
    finally:
        os.unlink(draft)
