"""Who may change a room: tokens signed with the server's secret, and where that is kept."""

import base64
import hashlib
import hmac
import os
import secrets
import tempfile
from pathlib import Path

from app.errors import NoTokenError, SettingError, TokenError

_BYTES = 32
_PURPOSE = b"plinko room "  # so that a signature made for one thing opens no other


class Tokens:
    """Signs and checks the tokens of rooms' creators. Nothing about a token is stored."""

    def __init__(self, secret: bytes) -> None:
        self._secret = secret

    def of(self, room_id: str) -> str:
        """The token of a room: HMAC-SHA256 over its id, in base64 for URLs, 43 characters."""
        signature = hmac.digest(self._secret, _PURPOSE + room_id.encode(), hashlib.sha256)
        return base64.urlsafe_b64encode(signature).rstrip(b"=").decode()

    def check(self, room_id: str, authorization: str | None) -> None:
        """Raise unless an Authorization header bears the room's token; in constant time.

        NoTokenError when it bears none, TokenError when it is another's. The token shown is in
        neither message.
        """
        shown = bearer_of(authorization)
        if shown is None:
            raise NoTokenError(
                f"room {room_id!r} is changed with the token that its creator was given, sent as "
                "`Authorization: Bearer TOKEN`",
                field="authorization",
            )
        if not hmac.compare_digest(shown.encode(), self.of(room_id).encode()):
            raise TokenError(f"the token is not that of room {room_id!r}", field="authorization")


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
