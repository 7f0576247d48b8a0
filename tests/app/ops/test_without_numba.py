"""The product works without numba, which users need not install."""

import json
import os
import subprocess
import sys
from pathlib import Path

HIDE = """
from importlib.machinery import PathFinder
found = PathFinder.find_spec
PathFinder.find_spec = lambda name, path=None, target=None: (
    None if name.partition(".")[0] in ("numba", "llvmlite") else found(name, path, target))
"""
"""As `sitecustomize` in Python's path, it hides numba from every process."""

MAKERS = (
    "plinko.engine.artifact.",
    "plinko.engine.jit.webassembly",
    "plinko.engine.jit.native_code",
    "plinko.engine.jit.llvm_module",
    "plinko.engine.jit.kernel_compiler",
)
"""Modules that compile kernels, which need numba."""

PROGRAM = f"""
import importlib, json, pkgutil, sys, warnings
from plinko import app, engine
for package in (engine, app):
    for each in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not each.name.startswith({MAKERS!r}) and ".migrations." not in each.name:
            importlib.import_module(each.name)
from plinko.engine import Board, World, drop, drop_many
from plinko.app.main import create_app
from plinko.app.render import drop_picture
from plinko.app.settings import Settings
warnings.simplefilter("ignore")
from starlette.testclient import TestClient

board = Board.preset("triangle-8")
one = drop(board, 42)
world = World(board)
world.add(seed=42)
while world.count:
    world.step()
with TestClient(create_app(Settings(database_url="sqlite://")), "http://127.0.0.1") as client:
    served = client.get("/api/v1/drops/triangle-8/42").json()["digest"]
    picture = client.get("/api/v1/drops/triangle-8/42.png").content
print(json.dumps({{
    "numba": "numba" in sys.modules,
    "drop": one.digest,
    "world": world.take_events()[-1].digest,
    "served": served,
    "batch": drop_many(board, range(50)).digest,
    "pictures": picture == drop_picture(one),
}}))
"""


def test_all_is_imported_and_drops_and_draws_without_numba(tmp_path: Path) -> None:
    from plinko.engine import drop, drop_many

    (tmp_path / "sitecustomize.py").write_text(HIDE, encoding="utf-8")
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", os.getcwd())])
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        check=True,
    )
    digest = drop("triangle-8", 42).digest
    assert json.loads(done.stdout) == {
        "numba": False,
        "drop": digest,
        "world": digest,
        "served": digest,
        "batch": drop_many("triangle-8", range(50)).digest,
        "pictures": True,
    }
