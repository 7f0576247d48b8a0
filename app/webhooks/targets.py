"""Who hears of drops and landings: the operator's list, a JSON file that is read at the start."""

import base64
import binascii
from collections.abc import Sequence
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

import msgspec

from app.errors import SettingError

_PREFIX: Final = "whsec_"
_LEAST, _MOST = 24, 64  # bytes of a secret, as https://www.standardwebhooks.com asks for


class Target(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An address that requests go to, and the secret that they are signed with.

    The secret is `whsec_` and 24 to 64 bytes in base 64.
    """

    url: str
    secret: str

    @property
    def key(self) -> bytes:
        """The secret's bytes; raises ValueError."""
        if not self.secret.startswith(_PREFIX):
            raise ValueError(f"a secret begins with {_PREFIX}")
        try:
            key = base64.b64decode(self.secret.removeprefix(_PREFIX), validate=True)
        except binascii.Error:
            raise ValueError(f"after {_PREFIX} a secret is base 64") from None
        if not _LEAST <= len(key) <= _MOST:
            raise ValueError(f"a secret has {_LEAST} to {_MOST} bytes, not {len(key)}")
        return key

    @property
    def name(self) -> str:
        """What logs and metrics call it: the rest of an address may be a secret too."""
        parts = urlsplit(self.url)
        return parts.netloc.rpartition("@")[2]

    def __repr__(self) -> str:
        return f"Target({self.name!r})"


def read_targets(file: str) -> Sequence[Target]:
    """The targets that a file lists, none without a file; raises SettingError."""
    if not file:
        return ()
    try:
        targets = msgspec.json.decode(Path(file).read_bytes(), type=tuple[Target, ...])
        for target in targets:
            _check(target)
        if len({target.url for target in targets}) < len(targets):
            raise ValueError("an address is there twice")
    except (OSError, ValueError) as error:
        raise SettingError(f"webhooks={file!r}: {error}", field="webhooks") from error
    return targets


def _check(target: Target) -> None:
    """Raise ValueError unless requests can be sent and signed; no error tells a secret."""
    parts = urlsplit(target.url)
    if parts.scheme not in ("http", "https") or not parts.hostname or parts.fragment:
        raise ValueError("an address is one such as https://example.org/plinko")
    try:
        assert target.key
    except ValueError as error:
        raise ValueError(f"{target.name}: {error}") from None
