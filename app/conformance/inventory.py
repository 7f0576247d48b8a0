"""Digests of the installed program and its configuration, which anybody can reproduce offline.

Each file gives a line `sha256  name`, in the format of `sha256sum` and in the order of the names'
bytes. The digest of a group of files is SHA-256 of its lines. docs/conformance.md describes the
groups.
"""

import hashlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Final

from plinko import app, engine
from plinko.app.errors import InvalidValueError, shorten
from plinko.app.rooms.canonical import canonical
from plinko.app.settings import Settings, static_directory

KERNELS: Final = (".wasm", ".so")
"""Endings of the names of kernels, which are shipped as compiled files."""

_UNTOLD: Final = frozenset({"data", "database_url", "host", "port", "relays"})
"""Settings, except secrets, of addresses and of the ledger's place. They do not change the game."""

_LINE: Final = re.compile("(?P<digest>[0-9a-f]{64})  (?P<name>.+)")

Files = dict[str, str]
"""SHA-256 of each file in hexadecimal, keyed by its name, such as `engine/seeding.py`."""


@dataclass(frozen=True, slots=True)
class Digests:
    """SHA-256 of each group, in hexadecimal."""

    code: str
    kernels: str
    configuration: str

    @property
    def whole(self) -> str:
        """SHA-256 of the other three, one per line."""
        return _sha256(f"{self.code}\n{self.kernels}\n{self.configuration}\n".encode())

    def to_dict(self) -> dict[str, str]:
        return {
            "code": self.code,
            "kernels": self.kernels,
            "configuration": self.configuration,
            "whole": self.whole,
        }


def installed() -> dict[str, Path]:
    """The directories of the program: the packages `app` and `engine`, and the pages `static`."""
    (server,), (physics,) = app.__path__, engine.__path__
    return {"app": Path(server), "engine": Path(physics), "static": static_directory()}


def files_of(roots: Mapping[str, Path]) -> Files:
    """The digest of each file below the directories `roots`, which are keyed by name.

    Folders called `__pycache__` do not count, because Python writes them itself. The pages are not
    part of `app`, even if they are installed inside it.
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
    """The lines from which a group's digest is computed, in the format of `sha256sum`."""
    return "".join(f"{files[name]}  {name}\n" for name in sorted(files, key=str.encode))


def from_list(text: str) -> Files:
    """Parse the output of `listed`; raises InvalidValueError naming the first invalid line."""
    found = {}
    for number, line in enumerate(text.splitlines(), 1):
        match = _LINE.fullmatch(line)
        if match is None:
            raise InvalidValueError(
                f"line {number}, {shorten(line)}, is not a SHA-256, two spaces and a file's name",
                field="list",
            )
        found[match["name"]] = match["digest"]
    return found


def first_difference(files: Files, expected: Files) -> str | None:
    """Say what is wrong with the first file, by name, that differs; None if all agree."""
    for name in sorted({*files, *expected}, key=str.encode):
        if name not in expected:
            return f"{name} is not in the list"
        if name not in files:
            return f"{name} is missing"
        if files[name] != expected[name]:
            return f"{name} differs: {files[name]}, not {expected[name]}"
    return None


def configuration_of(settings: Settings) -> dict[str, object]:
    """Every setting that may change the game, by name, without secrets.

    If the board of the room `main` is a file, its digest stands for its name.
    """
    shown = {
        entry.name: getattr(settings, entry.name)
        for entry in fields(settings)
        if not entry.metadata["secret"] and entry.name not in _UNTOLD
    }
    board = Path(settings.board)
    if board.is_file():
        shown["board"] = _sha256(board.read_bytes())
    return {
        name: list(value) if isinstance(value, tuple) else value for name, value in shown.items()
    }


def digests_of(files: Files, configuration: Mapping[str, object]) -> Digests:
    """The digests of the code, of the kernels, and of the configuration's canonical JSON."""
    return Digests(
        code=_listed_digest(files, (name for name in files if not name.endswith(KERNELS))),
        kernels=_listed_digest(files, (name for name in files if name.endswith(KERNELS))),
        configuration=_sha256(canonical(dict(configuration))),
    )


def digests(settings: Settings) -> Digests:
    """The digests of the installed program with these settings; reads every file."""
    return digests_of(files_of(installed()), configuration_of(settings))


def _listed_digest(files: Files, names: Iterable[str]) -> str:
    return _sha256(listed({name: files[name] for name in names}).encode())


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
