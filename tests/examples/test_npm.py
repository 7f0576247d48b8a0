"""The npm package of the page's solver is built, packed, installed and used as by a user."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from plinko import engine
from plinko.engine import Board, drop, drop_many, preset_names, verify
from tests.repository.test_repository import ROOT

BOARD = Board.preset("triangle-8")


def node_folder() -> str:
    done = subprocess.run([ROOT / "tools" / "node"], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def build_package(folder: Path) -> None:
    run(ROOT / "tools" / "npm-package", folder, sys.executable, cwd=ROOT)


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's project, into which the output of `npm pack` is installed."""
    folder = tmp_path_factory.mktemp("npm")
    in_it = folder / "node_modules" / "plinko-sim"
    build_package(in_it)
    (folder / "board.json").write_text(BOARD.to_json())
    return folder


def run(*command: object, cwd: Path) -> str:
    path = f"{node_folder()}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def script(project: Path, code: str) -> list[str]:
    (project / "try.mjs").write_text(code)
    return run("node", "try.mjs", cwd=project).splitlines()


def test_what_is_packed_is_the_solver_its_kernels_and_its_types(project: Path) -> None:
    package = project / "node_modules" / "plinko-sim"
    (packed,) = json.loads(run("npm", "pack", "--dry-run", "--json", "--offline", cwd=package))
    names = {each["path"] for each in packed["files"]}
    modules = {name for name in names if name.endswith(".js")}
    assert {"LICENSE", "README.md", "package.json", "solver/kernels.wasm"} <= names
    code = {name for name in modules if not name.startswith("presets/")}
    assert {name.removesuffix(".js") + ".d.ts" for name in code} <= names
    assert (packed["name"], packed["version"]) == ("plinko-sim", engine.__version__)


def test_every_export_is_there(project: Path) -> None:
    package = project / "node_modules" / "plinko-sim"
    exports = json.loads((package / "package.json").read_text("utf-8"))["exports"]
    assert len(exports) >= 8
    for target in exports.values():
        for file in target.values() if isinstance(target, dict) else [target]:
            assert [*package.glob(file.removeprefix("./"))], file
    presets = {path.stem for path in package.glob("presets/*.js")}
    assert presets == set(preset_names())


def test_a_drop_in_node_has_the_engine_s_digest(project: Path) -> None:
    said = script(
        project,
        """
        import { readFileSync } from "node:fs";
        import { openSolver } from "plinko-sim";
        import { compareRecords } from "plinko-sim/records";
        const board = JSON.parse(readFileSync("board.json", "utf8"));
        const bytes = readFileSync("node_modules/plinko-sim/solver/kernels.wasm");
        for (const solver of [await openSolver(), await openSolver(bytes)]) {
          const drop = solver.drop(board, { seed: "42" });
          console.log(drop.digest, compareRecords(drop.record(), drop.record()).difference);
        }
        """,
    )
    assert said == [f"{drop(BOARD, 42).digest} null"] * 2


def test_the_headline_drop_needs_no_server_and_is_its_record_as_json(project: Path) -> None:
    said = script(
        project,
        """
        import { Drop, openSolver } from "plinko-sim";
        import board from "plinko-sim/presets/triangle-16-high";
        const drop = (await openSolver()).drop(board, { seed: "21" });
        console.log(JSON.stringify(drop));
        console.log(drop instanceof Drop);
        """,
    )
    record = json.loads(said[0])
    assert verify({**record, "board": "triangle-16-high"}).ok
    assert record["digest"] == drop("triangle-16-high", 21).digest
    assert said[1] == "true"


def test_a_batch_is_computed_on_a_thread_and_may_be_cancelled(project: Path) -> None:
    said = script(
        project,
        """
        import { readFileSync } from "node:fs";
        import { Batch } from "plinko-sim/batch";
        const board = JSON.parse(readFileSync("board.json", "utf8"));
        const words = [];
        const note = ({ drops }) => words.push(drops);
        const whole = new Batch({ board, first: "0", drops: 1200 }, note);
        console.log(JSON.stringify((await whole.done).histogram), words.join());
        const part = new Batch({ board, first: "0", drops: 1e9 }, () => part.cancel());
        console.log((await part.done).drops < 1e9);
        const bad = new Batch({ board: { gravity: -1 }, first: "0", drops: 1 }, () => {});
        await bad.done.catch((error) => console.log(error.message.slice(0, 13)));
        """,
    )
    histogram = json.dumps(drop_many(BOARD, 1200).histogram.tolist(), separators=(",", ":"))
    assert said == [f"{histogram} 500,1000,1200", "true", "gravity is -1"]


def test_balls_that_touch_move_in_node(project: Path) -> None:
    said = script(
        project,
        """
        import { readFileSync } from "node:fs";
        import { World } from "plinko-sim/touching";
        import { loadMachine } from "plinko-sim/touching/machine";
        import { SCENES } from "plinko-sim/touching/scenes";
        const bytes = readFileSync("node_modules/plinko-sim/solver/touching/touching.wasm");
        const worlds = [];
        for (const machine of [await loadMachine(), await loadMachine(bytes)]) {
          const world = new World(machine, SCENES.sandbox, null);
          for (let i = 0; i < 10; i += 1) world.step();
          worlds.push(world.arena.table.pos.join());
        }
        console.log(worlds[0].length > 0, worlds[0] === worlds[1]);
        """,
    )
    assert said == ["true true"]


def test_the_types_and_the_readme_s_first_example_are_right(project: Path) -> None:
    readme = (project / "node_modules" / "plinko-sim" / "README.md").read_text("utf-8")
    examples = re.findall(r"```js\n(.*?)```", readme, re.DOTALL)
    types = (
        'import type { Board, Drop } from "plinko-sim";\nconst b: Board = board, d: Drop = drop;\n'
    )
    (project / "readme.mts").write_text("\n".join([*examples, types]))
    exports = json.loads((project / "node_modules/plinko-sim/package.json").read_text())["exports"]
    names = [
        name[2:] for name in exports if "." not in name[1:] and "*" not in name and name != "."
    ]
    every = [f'import * as m{i} from "plinko-sim/{name}";' for i, name in enumerate(names)]
    (project / "every.mts").write_text("\n".join(every))
    options = [
        "--ignoreConfig",
        "--strict",
        "--noEmit",
        "--target",
        "es2023",
        "--module",
        "nodenext",
    ]
    tsc = [ROOT / "node_modules" / ".bin" / "tsc", *options]
    run(*tsc, "--lib", "es2023", "every.mts", cwd=project)  # without the types of a page
    run(*tsc, "readme.mts", cwd=project)
    said = script(project, "\n".join(examples))
    assert said[0].startswith("9 ")
    assert "histogram" not in said[-1]
