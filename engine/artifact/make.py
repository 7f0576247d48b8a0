"""Writes the artifacts, and those of the pages: python -m plinko.engine.artifact.make

Each is compiled in a separate process, without any cache, so that the same sources give the same
bytes.
"""

import gzip
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

from plinko.engine.artifact.sample_calls import SAMPLE_CALLS

MOST_GZIPPED: Final = 40_000
"""Bytes of a page's module after gzip, at most."""

# numba leaves its LLVM code unoptimized, as `plinko.engine.jit.llvm_module.optimized` requires.
_UNCHANGED: Final = {**os.environ, "NUMBA_OPT": "0"}

FOLDER: Final = Path(__file__).parent
PAGE: Final = FOLDER.parents[1] / "static" / "js" / "solver" / "kernels.wasm"

PAGES: Final[Mapping[str, Path]] = {
    "exact": PAGE,
    "touching": PAGE.parent / "touching" / "touching.wasm",
}
"""The artifacts that pages load unchanged, and their files there."""


def made(name: str) -> bytes:
    return made_by(
        f"from plinko.engine.artifact import record_types; made = record_types.compiled({name!r})"
    )


def made_by(code: str) -> bytes:
    """The bytes that `code`, run as a separate program, assigns to `made`."""
    command = [sys.executable, "-c", f"{code}; import sys; sys.stdout.buffer.write(made)"]
    return subprocess.run(command, env=_UNCHANGED, stdout=subprocess.PIPE, check=True).stdout


def everything() -> Iterator[tuple[Path, bytes]]:
    """Compile all artifacts; each with the path of its file."""
    with ThreadPoolExecutor(os.cpu_count()) as processes:
        modules = list(processes.map(made, SAMPLE_CALLS))
    for name, module in zip(SAMPLE_CALLS, modules, strict=True):
        yield FOLDER / f"{name}.wasm", module
        if name in PAGES:
            yield PAGES[name], module


def main() -> int:
    """Compile and write all files. Returns 1 if a page's module has become too large."""
    for path, module in everything():
        packed = len(gzip.compress(module))
        if path in PAGES.values() and packed > MOST_GZIPPED:
            too_large = f"{path.name}: {packed} bytes gzipped, of at most {MOST_GZIPPED}"
            print(too_large)  # noqa: T201 - a command prints
            return 1
        path.write_bytes(module)
        print(f"{path.name}: {len(module)} bytes, {packed} gzipped")  # noqa: T201
    libraries = [sys.executable, "-m", "plinko.engine.artifact.libraries"]
    return subprocess.run(libraries, env=_UNCHANGED, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
