"""Engines for Node.js, each in a process that is kept between tasks, so that its JIT stays warm."""

import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.contestants.common import (
    LONGEST,
    AbsentError,
    Contestant,
    Floats,
    Paths,
    pairs,
    poll_steps,
    steps_of,
)
from benchmarks.contestants.python_engine import WORLD_BALLS
from plinko.engine import Board

FOLDER = Path(__file__).parents[1] / "node"
ENGINES = {
    "matter": "matter-js",
    "planck": "planck",
    "rapier": "Rapier",
    "box2d-wasm": "Box2D wasm",
}
"""Module in the folder benchmarks/node, and the name to print."""


def check() -> None:
    """Raise AbsentError if Node.js or the packages are not installed."""
    if shutil.which("node") is None:
        raise AbsentError("matter-js, planck, Rapier, Box2D wasm: Node.js is not installed")
    if not (FOLDER / "node_modules").is_dir():
        raise AbsentError(
            "matter-js, planck, Rapier, Box2D wasm: not installed; "
            "`npm install` in benchmarks/node installs them"
        )


class NodeProcess:
    """`node ARGUMENTS` in benchmarks/node: reads one JSON task per line, writes one line each."""

    def __init__(self, *arguments: str) -> None:
        self._name = " ".join(arguments)
        self._process = subprocess.Popen(
            ["node", *arguments],
            cwd=FOLDER,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def ask(self, task: dict[str, Any]) -> dict[str, Any]:
        """Return the process's answer; raises RuntimeError with the error that it reports."""
        assert self._process.stdin
        assert self._process.stdout
        self._process.stdin.write(json.dumps(task) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self._name} ended with exit code {self._process.wait()}")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise RuntimeError(f"{self._name}: {answer['error']}")
        return answer

    def close(self) -> None:
        """End the process."""
        if self._process.stdin:
            self._process.stdin.close()
        self._process.wait(10)
        if self._process.stdout:
            self._process.stdout.close()


class NodeEngine(Contestant):
    def __init__(self, module: str) -> None:
        self.name = ENGINES[module]
        self._process = NodeProcess("runner.mjs", module)

    def close(self) -> None:
        """End the process."""
        self._process.close()

    def seconds(self, board: Board, xs: Floats, dt: float) -> float:
        """Wall seconds of the steps, without the checks whether all balls have landed."""
        steps = int(LONGEST / dt)
        return sum(
            self._ask(board, xs[i : i + WORLD_BALLS], dt, steps, None)
            for i in range(0, len(xs), WORLD_BALLS)
        )

    def paths(self, board: Board, xs: Floats, dt: float, duration: float) -> Paths:
        steps = steps_of(duration, dt)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "states"
            self._ask(board, xs, dt, steps, path)
            states = np.fromfile(path).reshape(steps + 1, len(xs), 4)
        return Paths(dt, states[..., :2].copy(), states[..., 2:].copy())

    def _ask(self, board: Board, xs: Floats, dt: float, steps: int, record: Path | None) -> float:
        task = {
            "board": _board(board),
            "xs": xs.tolist(),
            "dt": dt,
            "steps": steps,
            "poll": poll_steps(dt),
            "record": str(record) if record else None,
        }
        return float(self._process.ask(task)["seconds"])


def _board(board: Board) -> dict[str, Any]:
    peg, wall = pairs(board)
    return {
        "gravity": board.gravity,
        "drag": board.drag,
        "radius": board.ball.radius,
        "density": board.ball.density,
        "y": board.drop.y,
        "bins_y": board.bins.y,
        "pegs": [[p.x, p.y, p.radius] for p in board.pegs],
        "walls": [[w.x1, w.y1, w.x2, w.y2] for w in board.walls],
        "peg": [peg.restitution, peg.friction],
        "wall": [wall.restitution, wall.friction],
    }
