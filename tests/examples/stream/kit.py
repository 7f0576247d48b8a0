"""Runs the stream kit as a streamer does, and reads what it has done from its journal."""

import asyncio
import contextlib
import json
import re
import signal
import sqlite3
import sys
from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from typing import Any, Final

from tests.app.conftest import TINY
from tests.kit.waiting import LIMIT
from tests.repository.test_repository import ROOT

STREAM: Final = ROOT / "examples" / "stream"

QUICK: Final = {**TINY, "gravity": 4000.0}  # its balls land in two ticks


class Kit:
    """The kit's process in a folder with its rules; it can be killed and started again."""

    def __init__(self, folder: Path, server: str, rules: str, game: str = "") -> None:
        self.folder = folder
        self.lines: list[str] = []  # that it has printed
        self._process: asyncio.subprocess.Process | None = None
        (folder / "board.json").write_text(json.dumps(QUICK))
        head = (
            f'[game]\nserver = "{server}"\nboard = "board.json"\nport = 0\nevery = 0.01\n{game}\n'
        )
        (folder / "rules.toml").write_text(f"{head}\n{rules}")

    async def start(self) -> None:
        """Return once it says where the stage is."""
        with (self.folder / "log").open("a") as log:
            self._process = await asyncio.create_subprocess_exec(
                *(sys.executable, str(STREAM / "kit.py"), str(self.folder / "rules.toml")),
                stdout=asyncio.subprocess.PIPE,
                stderr=log,
            )
        self.lines.clear()
        await self.prints("The stage is at")

    async def prints(self, text: str) -> str:
        """The line with this text, once it is there."""
        assert self._process is not None
        assert self._process.stdout is not None
        async with asyncio.timeout(LIMIT):
            while not any(text in line for line in self.lines):
                line = (await self._process.stdout.readline()).decode()
                assert line, (self.folder / "log").read_text()
                self.lines.append(line.strip())
        return next(line for line in self.lines if text in line)

    async def end(self, how: signal.Signals = signal.SIGKILL) -> None:
        assert self._process is not None
        if self._process.returncode is None:
            self._process.send_signal(how)
        await self._process.communicate()

    @property
    def address(self) -> str:
        """The address for other programs."""
        return next(line.split()[-1] for line in self.lines if line.endswith("/event"))

    @property
    def room(self) -> str:
        return str(self.state("room"))

    def state(self, name: str) -> Any:
        return json.loads(self.rows("SELECT value FROM state WHERE name = ?", name)[0][0])

    def rows(self, query: str, *values: object) -> Sequence[Any]:
        with contextlib.closing(sqlite3.connect(self.folder / "kit.db", timeout=LIMIT)) as db:
            return db.execute(query, values).fetchall()

    def balls(self) -> dict[str, int]:
        """How many balls of each viewer have landed."""
        found = self.rows(
            "SELECT e.name, count(*) FROM balls b JOIN events e ON e.id = b.event "
            "WHERE b.landed IS NOT NULL GROUP BY e.name"
        )
        return dict(found)

    @property
    def waiting(self) -> int:
        return int(self.rows("SELECT count(*) FROM balls WHERE landed IS NULL")[0][0])

    @property
    def log(self) -> str:
        return re.sub(r"(?m)^[\d:]+ ", "", (self.folder / "log").read_text())


@contextlib.asynccontextmanager
async def running(folder: Path, server: str, rules: str, game: str = "") -> AsyncIterator[Kit]:
    kit = Kit(folder, server, rules, game)
    await kit.start()
    try:
        yield kit
    finally:
        await kit.end()
