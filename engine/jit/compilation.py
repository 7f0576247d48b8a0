"""A process that compiles a kernel by numba while this one works on, and the code that it leaves.

Both are gone with this process. Loaded when the first is needed.
"""

import atexit
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from engine.jit.decorator import EntryKernel

ROOT: Final = Path(__file__).parents[2]
"""Of the program that compiles: where it finds `engine`."""


def named(kernel: str) -> Any:
    """The kernel of a name: `engine.exact.trace.trace_many`."""
    module, _, attribute = kernel.rpartition(".")
    return getattr(import_module(module), attribute)


def kept(kernel: EntryKernel[Any, Any], folder: Path) -> Any:
    """The kernel as numba's function, whose code is read in a folder, or left there.

    The folder must not outlive this process or one that started it: numba takes such code for fresh
    though it contains that of functions in files which have changed.
    """
    config = import_module("numba").config
    code = import_module("engine.jit.kernel_compiler").compiled(kernel)
    usual, config.CACHE_DIR = config.CACHE_DIR, str(folder)
    try:
        code.enable_caching()
    finally:
        config.CACHE_DIR = usual
    return code


class Compilation:
    """Of a kernel of this name, for the types that `play` calls it with (engine/artifact/plays.py).

    Begun at once; raises OSError where there is no room for a process or its folder.
    """

    def __init__(self, kernel: str, play: str) -> None:
        self._kernel = kernel
        self._folder = tempfile.TemporaryDirectory(prefix="plinko-")
        try:
            self._process = _started(kernel, play, self._folder.name)
        except OSError:
            self._folder.cleanup()
            raise
        atexit.register(self._end)

    @property
    def done(self) -> bool:
        """Whether it has ended, well or not."""
        return self._process.poll() is not None

    def wait(self) -> None:
        """Until it is done."""
        self._process.wait()

    def use(self) -> bool:
        """Run the kernel by numba's code from now on; False if it could not compile.

        For one that is done; numba is loaded, which takes up to a second.
        """
        if self._process.returncode != 0:
            return False
        kernel = named(self._kernel)
        kernel.machine_code = kept(kernel, Path(self._folder.name))
        return True

    def _end(self) -> None:
        self._process.kill()
        self._process.wait()
        self._folder.cleanup()


def _started(*arguments: str) -> subprocess.Popen[bytes]:
    """The program that compiles."""
    return subprocess.Popen(
        [sys.executable, "-m", "engine.artifact.compile_kernel", *arguments],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # an interrupt from the keyboard is not for it
    )
