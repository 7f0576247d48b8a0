"""Who may change a room or drop in a session: tokens, and where the server's secrets are kept."""

import base64
import hashlib
import hmac
import os
import secrets
import tempfile
from pathlib import Path

from app.errors import NoTokenError, SettingError, TokenError

_BYTES = 32


class Tokens:
    """Signs and checks the tokens of rooms' creators. Nothing about a token is stored.

    `kind` is what they are for, so that a token made for one thing opens no other.
    """

    def __init__(self, secret: bytes, kind: str = "room") -> None:
        self._secret = secret
        self._kind = kind

    def of(self, room_id: str) -> str:
        """The token of this id: HMAC-SHA256 over it, in base64 for URLs, 43 characters."""
        purpose = f"plinko {self._kind} ".encode()
        signature = hmac.digest(self._secret, purpose + room_id.encode(), hashlib.sha256)
        return base64.urlsafe_b64encode(signature).rstrip(b"=").decode()

    def mark_of(self, address: str) -> str:
        """A mark of whoever made something: it is the same for one address, and does not say it."""
        return self.of(f"creator {address}")

    def check(self, room_id: str, authorization: str | None) -> None:
        """Raise unless an Authorization header bears the token of this id; in constant time.

        NoTokenError when it bears none, TokenError when it is another's. The token shown is in
        neither message.
        """
        self.check_shown(room_id, bearer_of(authorization))

    def check_shown(self, room_id: str, shown: str | None) -> None:
        """`check` of a token that came some other way, None for none."""
        if shown is None:
            raise NoTokenError(
                f"{self._kind} {room_id!r} is changed with the token that its creator was given, "
                "sent as `Authorization: Bearer TOKEN`",
                field="authorization",
            )
        if not hmac.compare_digest(shown.encode(), self.of(room_id).encode()):
            raise TokenError(
                f"the token is not that of {self._kind} {room_id!r}", field="authorization"
            )


class SessionTokens(Tokens):
    """The tokens of players' sessions.

    One that the owner of a room has begun there has another token, which also gives the owner's
    right to give names: a request has one header for tokens, and so need not show both.
    """

    def __init__(self, secret: bytes) -> None:
        super().__init__(secret, "session")
        self._owners = Tokens(secret, "session of an owner")

    def of_owner(self, session_id: str) -> str:
        """The token of a session that the room's owner has begun."""
        return self._owners.of(session_id)

    def is_owners(self, session_id: str, authorization: str | None) -> bool:
        """Whether an Authorization header bears that token; in constant time."""
        return self._is_owners(session_id, bearer_of(authorization))

    def _is_owners(self, session_id: str, shown: str | None) -> bool:
        wanted = self._owners.of(session_id).encode()
        return shown is not None and hmac.compare_digest(shown.encode(), wanted)

    def check_shown(self, room_id: str, shown: str | None) -> None:
        """`check` of a token that came some other way; the owner's is one, too."""
        if not self._is_owners(room_id, shown):
            super().check_shown(room_id, shown)


def check_bearer(authorization: str | None, token: str, whose: str) -> None:
    """Raise NoTokenError or TokenError unless an Authorization header bears just this token.

    In constant time; `whose` says whose token it is, for the message.
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
    """The token that an Authorization header bears, if any."""
    scheme, _, shown = (authorization or "").partition(" ")
    return shown.strip() or None if scheme.lower() == "bearer" else None


def secret_of(given: str, file: Path | None) -> bytes:
    """The server's secret: the one given, or the one in `file`, made there if need be.

    With neither it lives as long as the process. The file is for its owner's eyes alone. Raises
    SettingError naming a file that cannot be read or made.
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
            f"the secret in {file}: {error.strerror or error}", field="data"
        ) from error
    if len(found) < _BYTES:
        raise SettingError(
            f"the secret in {file} has {len(found)} characters, fewer than {_BYTES}; delete the "
            "file to have a new one made, which ends the validity of all tokens",
            field="data",
        )
    return found


def signing_key_of(file: Path | None) -> bytes:
    """The 32 bytes that the server signs sessions with: as `secret_of` keeps its secret.

    Raises SettingError naming a file that is none.
    """
    digits = secret_of("", file)
    if file is None:
        return digits
    try:
        key = bytes.fromhex(digits.decode())
    except ValueError:
        key = b""
    if len(key) != _BYTES:
        raise SettingError(
            f"the key in {file} is not {2 * _BYTES} hexadecimal digits; restore it, as what was "
            "signed with it can be checked against no other",
            field="data",
        )
    return key


def _make(file: Path) -> None:
    """Write a new secret unless there is one; whole or not at all, whoever else tries it too."""
    if file.exists():
        return
    # For its owner alone, and under a name that no other process has left behind.
    descriptor, draft = tempfile.mkstemp(prefix=f"{file.name}.", dir=file.parent)
    try:
        with os.fdopen(descriptor, "w") as out:
            out.write(secrets.token_hex(_BYTES) + "\n")
            out.flush()
            os.fsync(out.fileno())
        # Unlike a rename, a link leaves the file alone that another was quicker to make.
        os.link(draft, file)
    except FileExistsError:
        return
    finally:
        os.unlink(draft)
