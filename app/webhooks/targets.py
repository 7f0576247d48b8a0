"""The targets of webhooks: the operator's list, a JSON file that is read at the start."""

import base64
import binascii
from collections import Counter
from collections.abc import Sequence
from typing import Final
from urllib.parse import SplitResult, urlsplit

import msgspec

from plinko.app.errors import SettingError
from plinko.engine import json_text

_PREFIX: Final = "whsec_"
_LEAST, _MOST = 24, 64  # bytes of a secret, by https://www.standardwebhooks.com


class Target(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The address that requests go to, and the secret that signs them.

    The secret is `whsec_` and then 24 to 64 bytes in base64.
    """

    url: str
    secret: str

    @property
    def key(self) -> bytes:
        """The secret's bytes; raises ValueError."""
        if not self.secret.startswith(_PREFIX):
            raise ValueError(f"the secret must begin with {_PREFIX}")
        try:
            key = base64.b64decode(self.secret.removeprefix(_PREFIX), validate=True)
        except binascii.Error:
            raise ValueError(f"the secret must be base64 after {_PREFIX}") from None
        if not _LEAST <= len(key) <= _MOST:
            raise ValueError(f"the secret must have {_LEAST} to {_MOST} bytes, not {len(key)}")
        return key

    @property
    def host(self) -> str:
        """Host and port: the path may be secret."""
        return urlsplit(self.url).netloc.rpartition("@")[2]

    def __repr__(self) -> str:
        return f"Target({self.host!r})"


def names_of(targets: Sequence[Target]) -> list[str]:
    """Names for logs and metrics: the host, and from its second target on a number."""
    names: list[str] = []
    met = Counter[str]()
    for target in targets:
        met[target.host] += 1
        number = met[target.host]
        names.append(target.host if number == 1 else f"{target.host} ({number})")
    return names


def read_targets(file: str) -> Sequence[Target]:
    """The targets that `file` lists, or none if it is empty text; raises SettingError."""
    if not file:
        return ()
    try:
        targets = msgspec.convert(json_text.parse(json_text.read_text(file)), tuple[Target, ...])
        for target in targets:
            _check(target)
        if len({target.url for target in targets}) < len(targets):
            raise ValueError("two targets have the same address")
    except (OSError, ValueError) as error:
        raise SettingError(f"webhooks={file!r}: {error}", field="webhooks") from error
    return targets


def _check(target: Target) -> None:
    """Raise ValueError if requests cannot be sent or signed; no message contains a secret."""
    parts = urlsplit(target.url)
    if parts.scheme not in ("http", "https") or not parts.hostname or parts.fragment:
        raise ValueError("an address must be a URL such as https://example.org/plinko")
    if not _is_port_valid(parts):
        raise ValueError(
            f"{target.host}: the port must be from 1 to 65535, or left out with its colon"
        )
    try:
        assert target.key
    except ValueError as error:
        raise ValueError(f"{target.host}: {error}") from None


def _is_port_valid(parts: SplitResult) -> bool:
    try:
        return parts.port != 0 and not parts.netloc.endswith(":")
    except ValueError:
        return False
