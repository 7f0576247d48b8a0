"""The artifact's stamp: what it says it was made from, and what the kernels are now."""

import hashlib
import json
from pathlib import Path
from typing import Any, Final

from engine.constants import PHYSICS_VERSION
from engine.jit.wasm_sections import custom, with_custom

FILE: Final = Path(__file__).with_name("kernels.wasm")

SECTION: Final = "plinko"
"""Name of the custom section that holds the stamp, as JSON."""

_ENGINE: Final = Path(__file__).parents[1]


def sources() -> list[Path]:
    """All files of Python that the artifact's machine code is made of."""
    here = _ENGINE / "artifact"
    found = [_ENGINE / "constants.py", here / "entries.py"]
    found += [_ENGINE / "jit" / name for name in ("webassembly.py", "wasm_sections.py")]
    for package in ("physics", "exact"):
        found += (_ENGINE / package).glob("*.py")
    return sorted(found)


def current() -> dict[str, Any]:
    """The stamp of an artifact that is made now."""
    text = b"\0".join(path.read_bytes() for path in sources())
    return {"physics_version": PHYSICS_VERSION, "sources": hashlib.sha256(text).hexdigest()}


def stamped(module: bytes) -> bytes:
    """The module with the current stamp."""
    return with_custom(module, SECTION, json.dumps(current()).encode())


def stamp_of(module: bytes) -> dict[str, Any]:
    """What an artifact says it was made from; ValueError if it says nothing."""
    content = custom(module, SECTION)
    if content is None:
        raise ValueError(f"the module has no section {SECTION!r}: it is not made by `make kernels`")
    stamp: dict[str, Any] = json.loads(content)
    return stamp
