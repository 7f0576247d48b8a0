"""Writes the artifacts, and the pages' modules beside them: python -m engine.artifact.make

Each is compiled in a process of its own, by numba's public names, and nothing that was compiled
before is read: the same sources then give the same bytes.
"""

import gzip
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

from engine.artifact.plays import PLAYS
from engine.jit import stamp

MOST_GZIPPED: Final = 40_000
"""Bytes that a page may have to load for it."""

_UNCHANGED: Final = {**os.environ, "NUMBA_OPT": "0"}

FOLDER: Final = Path(__file__).parent
PAGE: Final = FOLDER.parents[1] / "static" / "js" / "solver" / "kernels.wasm"

TOUCHING_PAGE: Final = PAGE.parent / "touching" / "touching.wasm"
"""The artifact `touching`, which pages have as it is."""


def for_pages() -> bytes:
    """The page's artifact, made now."""
    code = (
        "from engine.artifact.entries import EXPORTS; "
        "from engine.jit.webassembly import compile_module; "
        "made = compile_module(EXPORTS)"
    )
    return stamp.stamped(made_by(code), stamp.current())


def made(name: str) -> bytes:
    """An artifact of PLAYS, made now."""
    return made_by(f"from engine.artifact import rehearsal; made = rehearsal.compiled({name!r})")


def made_by(code: str) -> bytes:
    """What a program of its own leaves in `made`, in which numba leaves its code as it is."""
    command = [sys.executable, "-c", f"{code}; import sys; sys.stdout.buffer.write(made)"]
    return subprocess.run(command, env=_UNCHANGED, stdout=subprocess.PIPE, check=True).stdout


def everything() -> Iterator[tuple[Path, bytes]]:
    """All artifacts, made now, each with its file."""
    with ThreadPoolExecutor(os.cpu_count()) as processes:
        page = processes.submit(for_pages)
        ours = list(zip(PLAYS, processes.map(made, PLAYS), strict=True))
        yield PAGE, page.result()
    for name, module in ours:
        yield FOLDER / f"{name}.wasm", module
        if name == TOUCHING_PAGE.stem:
            yield TOUCHING_PAGE, module


def main() -> int:
    """Compile and write; 1 if what pages load has become too large."""
    for path, module in everything():
        packed = len(gzip.compress(module))
        if path in {PAGE, TOUCHING_PAGE} and packed > MOST_GZIPPED:
            print(f"{packed} bytes gzipped: more than {MOST_GZIPPED}")  # noqa: T201 - a command prints
            return 1
        path.write_bytes(module)
        print(f"{path.name}: {len(module)} bytes, {packed} gzipped")  # noqa: T201
    libraries = [sys.executable, "-m", "engine.artifact.libraries"]
    return subprocess.run(libraries, env=_UNCHANGED, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
