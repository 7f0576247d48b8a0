"""An artifact's stamp: what it says it was made from, and what the kernels are now."""

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any, Final

from engine.constants import PHYSICS_VERSION
from engine.jit.wasm_sections import custom, with_custom

SECTION: Final = "plinko"
"""Name of the custom section that holds the stamp and what else is said of a module, as JSON."""

ENGINE: Final = Path(__file__).parents[1]


def sources() -> list[Path]:
    """All files of Python that machine code is made of."""
    found = [ENGINE / "constants.py", ENGINE / "certified" / "reach.py"]
    found += [ENGINE / "artifact" / name for name in ("entries.py", "plays.py", "rehearsal.py")]
    found += [ENGINE / "jit" / name for name in ("calls.py", "kernel_compiler.py")]
    found += [ENGINE / "jit" / name for name in ("webassembly.py", "wasm_sections.py")]
    for package in ("physics", "exact", "stepped", "multibody/solver", "billiards"):
        found += (ENGINE / package).rglob("*.py")
    return sorted(found)


@cache
def current() -> dict[str, Any]:
    """The stamp of an artifact that is made now."""
    return stamp_of_files(sources())


def stamp_of_files(files: list[Path]) -> dict[str, Any]:
    """The stamp of an artifact that is made of these."""
    text = b"\0".join(path.read_bytes() for path in files)
    return {"physics_version": PHYSICS_VERSION, "sources": hashlib.sha256(text).hexdigest()}


def stamped(module: bytes, **said: Any) -> bytes:
    """The module with the current stamp, and whatever else it is to say."""
    return with_custom(module, SECTION, json.dumps({**current(), **said}).encode())


def read(module: bytes) -> dict[str, Any]:
    """What an artifact says of itself; ValueError if it says nothing."""
    content = custom(module, SECTION)
    if content is None:
        raise ValueError(f"the module has no section {SECTION!r}: it is not made by `make kernels`")
    said: dict[str, Any] = json.loads(content)
    return said


def is_current(said: dict[str, Any]) -> bool:
    """Whether an artifact that says so was made from the sources as they are."""
    return current().items() <= said.items()
