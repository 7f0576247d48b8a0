"""Runs the examples of pages: `python -m tools.readme [PAGE…]` updates their output.

A ```console block has commands (`$ ...`), each followed by its output. A ```python block is a
program, and the ```text block after it is its output. Commands run in order in a temporary folder,
with a server for those that use http://127.0.0.1:8000.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.kit.process import ServerProcess
from tools import photographs

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
INDEX = ROOT / "docs" / "index.md"
QUICKSTART = ROOT / "docs" / "quickstart.md"
PAGES = (README, INDEX, QUICKSTART, ROOT / "docs" / "pictures.md")
IMAGES = Path("docs/images")
ADDRESS = "http://127.0.0.1:8000"

_CONSOLE = re.compile(r"```console\n(.*?)```", re.DOTALL)
_PYTHON = re.compile(r"```python\n(.*?)```\n+```text\n(.*?)```", re.DOTALL)
# Output that differs between machines: times, and sizes of compressed files.
_MEASURED = re.compile(r"[\d,.]+ (?=drops/s|bytes)|(?<=drops/s, )[\d.]+ (?=s\b)")


@dataclass(frozen=True)
class Example:
    """A command or program, the output shown by the page, and where it is shown."""

    code: str
    says: str
    start: int  # of the shown output, in the page's text
    end: int
    is_program: bool


def examples(text: str) -> list[Example]:
    """All examples in order."""
    found = []
    for block in _CONSOLE.finditer(text):
        for command in re.finditer(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block[1], re.MULTILINE):
            start = block.start(1) + command.start(2)
            found.append(Example(command[1], command[2], start, start + len(command[2]), False))
    for block in _PYTHON.finditer(text):
        found.append(Example(block[1], block[2], block.start(2), block.end(2), True))
    return sorted(found, key=lambda example: example.start)


def pictures(example: Example) -> list[str]:
    """The picture files that an example writes."""
    return re.findall(rf"{IMAGES}/[\w.-]+", example.code)


def without_measurements(text: str) -> str:
    """An example's output without the parts that differ between machines."""
    return _MEASURED.sub("# ", text)


class Runner:
    """Runs examples one after another in one folder."""

    def __init__(self, folder: Path, address: str) -> None:
        self.folder = folder
        self.address = address
        (folder / IMAGES).mkdir(parents=True, exist_ok=True)

    def run(self, example: Example) -> str:
        """Run the example and return its output; raises CalledProcessError if it fails."""
        if example.is_program:
            command = [sys.executable, "-c", example.code]
        else:
            code = example.code.replace(ADDRESS, self.address)
            command = ["bash", "-c", f"set -o pipefail; {_CURL}{code}"]
        # This environment's programs come first on the PATH, as if it were activated.
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        done = subprocess.run(
            command,
            cwd=self.folder,
            env={**os.environ, "PATH": path},
            stdout=subprocess.PIPE,
            text=True,
            check=False,
        )
        allowed = {0, 1 if "plinko verify" in example.code else 0}
        if "| head" in example.code:
            allowed.add(128 + signal.SIGPIPE)  # `head` has read enough before the program ended
        if done.returncode not in allowed:
            raise subprocess.CalledProcessError(done.returncode, example.code, done.stdout)
        return done.stdout.replace(self.address, ADDRESS)


# Without curl, a Python function takes its place.
_CURL = "" if shutil.which("curl") else (
    "curl() { python -c 'import sys, urllib.request as u; "
    "sys.stdout.buffer.write(u.urlopen(sys.argv[-1]).read())' \"$@\"; }; "
)  # fmt: skip


@contextmanager
def runner() -> Iterator[Runner]:
    """A runner with a temporary server and folder."""
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        server = stack.enter_context(ServerProcess("sqlite://"))
        yield Runner(Path(folder), server.url)


def main(pages: Sequence[str]) -> None:
    """Write the output of the examples into these pages, and their pictures next to them."""
    with runner() as run:
        for page in [ROOT / name for name in pages] or PAGES:
            renew(page, run)
        for picture in (run.folder / IMAGES).iterdir():
            (ROOT / IMAGES).mkdir(exist_ok=True)
            shutil.copy(picture, ROOT / IMAGES)
        if not pages:
            photographs.take(run.address, ROOT / IMAGES)


def renew(page: Path, run: Runner) -> None:
    """Write the output of a page's examples into the page."""
    text = page.read_text(encoding="utf-8")
    found = examples(text)
    prints = [run.run(example) for example in found]
    for example, printed in reversed(list(zip(found, prints, strict=True))):
        text = text[: example.start] + printed + text[example.end :]
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
