"""The program as installed, and how it is set up, as digests that anybody can reproduce offline.

Each file is a line `sha256  name`, as `sha256sum` writes it, in the order of the names' bytes; the
digest of a group of files is SHA-256 of these lines. docs/conformance.md says what is in a group.
"""

import hashlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Final

import app
import engine
from app.errors import InvalidValueError, shorten
from app.rooms.canonical import canonical
from app.settings import Settings, static_directory

KERNELS: Final = (".wasm", ".so")
"""End the names of kernels that come compiled; whatever else is compiled, is so from the code."""

_UNTOLD: Final = frozenset({"data", "database_url", "host", "port", "relays"})
"""Settings that say where the server is and keeps its ledger, not how it plays. Secrets aside."""

_LINE: Final = re.compile("(?P<digest>[0-9a-f]{64})  (?P<name>.+)")

Files = dict[str, str]
"""SHA-256 of each file, in hexadecimal, by its name, such as `engine/seeding.py`."""


@dataclass(frozen=True, slots=True)
class Digests:
    """SHA-256, in hexadecimal, of each group; `whole` is of the other three, one a line."""

    code: str
    kernels: str
    configuration: str

    @property
    def whole(self) -> str:
        """One digest of all."""
        return _sha256(f"{self.code}\n{self.kernels}\n{self.configuration}\n".encode())

    def to_dict(self) -> dict[str, str]:
        """The JSON form."""
        return {
            "code": self.code,
            "kernels": self.kernels,
            "configuration": self.configuration,
            "whole": self.whole,
        }


def installed() -> dict[str, Path]:
    """Where the program's files are: of the packages `app` and `engine`, and the pages `static`."""
    (server,), (physics,) = app.__path__, engine.__path__
    return {"app": Path(server), "engine": Path(physics), "static": static_directory()}


def files_of(roots: Mapping[str, Path]) -> Files:
    """The digest of each file below each of `roots`, which are directories by name.

    But for what Python and its compiler write themselves: folders called `__pycache__`. The pages
    are no part of `app`, even where they are installed inside it.
    """
    found = {}
    for name, root in roots.items():
        inside = [other for other in roots.values() if root in other.parents]
        for path in root.rglob("*"):
            apart = "__pycache__" in path.parts or any(each in path.parents for each in inside)
            if path.is_file() and not apart:
                found[f"{name}/{path.relative_to(root).as_posix()}"] = _sha256(path.read_bytes())
    return found


def listed(files: Files) -> str:
    """The lines that a digest is of, as `sha256sum` writes them."""
    return "".join(f"{files[name]}  {name}\n" for name in sorted(files, key=str.encode))


def from_list(text: str) -> Files:
    """What `listed` gave, read again; raises InvalidValueError naming a line that is none of it."""
    found = {}
    for number, line in enumerate(text.splitlines(), 1):
        match = _LINE.fullmatch(line)
        if match is None:
            raise InvalidValueError(
                f"line {number}, {shorten(line)}, is not a SHA-256, two blanks and a file's name",
                field="list",
            )
        found[match["name"]] = match["digest"]
    return found


def first_difference(files: Files, expected: Files) -> str | None:
    """The first file, by name, that is not as expected, and what is wrong; None where all are."""
    for name in sorted({*files, *expected}, key=str.encode):
        if name not in expected:
            return f"{name} is not in the list"
        if name not in files:
            return f"{name} is missing"
        if files[name] != expected[name]:
            return f"{name} differs: {files[name]}, not {expected[name]}"
    return None


def configuration_of(settings: Settings) -> dict[str, object]:
    """Every setting that may change how the server plays, by name; no secret is in it.

    The board of the room `main`, where it is a file, counts by its content.
    """
    told = {
        entry.name: getattr(settings, entry.name)
        for entry in fields(settings)
        if not entry.metadata["secret"] and entry.name not in _UNTOLD
    }
    board = Path(settings.board)
    if board.is_file():
        told["board"] = _sha256(board.read_bytes())
    return {
        name: list(value) if isinstance(value, tuple) else value for name, value in told.items()
    }


def digests_of(files: Files, configuration: Mapping[str, object]) -> Digests:
    """The digests of these files, kernels apart, and of the configuration's canonical JSON."""
    return Digests(
        code=_listed_digest(files, (name for name in files if not name.endswith(KERNELS))),
        kernels=_listed_digest(files, (name for name in files if name.endswith(KERNELS))),
        configuration=_sha256(canonical(dict(configuration))),
    )


def digests(settings: Settings) -> Digests:
    """Of the program as it is installed now, set up like this; reads every file."""
    return digests_of(files_of(installed()), configuration_of(settings))


def _listed_digest(files: Files, names: Iterable[str]) -> str:
    return _sha256(listed({name: files[name] for name in names}).encode())


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
