"""The wheel, built from the source distribution and installed, as users get it from an index."""

import base64
import email
import hashlib
import json
import re
import subprocess
import zipfile
from pathlib import Path

import pytest

from plinko import engine
from plinko.engine.jit import native
from tests.repository.conftest import Installed
from tests.repository.test_repository import PROJECT, ROOT
from tools.golden.check import golden


def test_the_wheel_has_engine_server_and_page_and_nothing_else(
    installed: Installed,
) -> None:
    with zipfile.ZipFile(installed.source) as archive:
        names = set(archive.namelist())
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        told = email.message_from_bytes(archive.read(metadata))
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == {"plinko"}
    assert not [name for name in names if re.search("bench|billiards|app/load", name)]
    assert {"plinko/py.typed", "plinko/static/index.html"} <= names
    assert {
        f"plinko/engine/artifact/native/{each.name}" for each in native.FOLDER.iterdir()
    } <= names
    assert (told["Name"], told["Version"]) == ("plinko-sim", engine.__version__)
    assert told["License-Expression"] == "MIT"
    assert set(told.get_all("Provides-Extra", [])) == {
        *("server", "postgres", "certify", "redis", "batches", "table", "video"),
    }


def test_an_installed_package_makes_and_verifies_the_golden_drop(
    installed: Installed,
) -> None:
    done = installed.run("plinko", "drop", "triangle-8", "--seed", "42", "--json")
    record = json.loads(done.stdout)
    assert record["digest"] == golden()["drops"]["triangle-8"]["exact"][0]
    (installed.folder / "record.json").write_text(done.stdout)
    assert installed.run("plinko", "verify", "record.json").returncode == 0
    assert installed.run("plinko", "--version").stdout.strip() == engine.__version__
    assert installed.run("python", "-m", "plinko", "verify", "record.json").returncode == 0


def test_an_installed_package_is_found_there_and_paints(
    installed: Installed,
) -> None:
    code = (
        "import plinko, importlib.metadata as m\n"
        "from plinko import engine\n"
        "from plinko.app.settings import static_directory\n"
        "print(engine.__file__)\n"
        "print(static_directory())\n"
        "print(engine.__version__ == m.version('plinko-sim'))\n"
        "print(plinko.Board.preset('triangle-8')._repr_png_()[1:4])\n"
    )
    where, page, same, picture = installed.python(code).splitlines()
    assert Path(where).is_relative_to(installed.folder)
    assert (Path(page) / "theme.json").is_file()
    assert Path(page).is_relative_to(installed.folder)
    assert (same, picture) == ("True", "b'PNG'")


RECORDED = """
from importlib.metadata import files
for file in files("plinko-sim"):
    if file.parts[0] == "plinko" and file.hash:
        print(file, file.hash.value)
"""


def test_the_wheel_records_the_digest_of_each_file_of_the_source(installed: Installed) -> None:
    recorded = dict(line.split() for line in installed.python(RECORDED).splitlines())
    source = {
        f"plinko/{path.relative_to(ROOT)}": path
        for folder in ("app", "engine", "static")
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    own = (ROOT / "src" / "plinko").iterdir()
    source |= {f"plinko/{path.name}": path for path in own if path.is_file()}
    digests = {
        name: base64.urlsafe_b64encode(hashlib.sha256(path.read_bytes()).digest()).decode()
        for name, path in source.items()
    }
    assert recorded == {name: digest.rstrip("=") for name, digest in digests.items()}


WITHOUT_SERVER = """
import sys
for name in {modules!r}:
    sys.modules[name] = None
from plinko.app.cli import main
sys.exit(main({arguments!r}))
"""


def without_server(installed: Installed, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a command without the dependencies of extras, as if only the package were installed."""
    extras = PROJECT["project"]["optional-dependencies"]
    needed = {line for name in ("server", "certify", "table") for line in extras[name]}
    modules = [re.match(r"[\w-]+", line)[0].replace("-", "_") for line in needed]  # type: ignore[index]
    modules = ["flint" if name == "python_flint" else name for name in modules]
    return installed.run(
        "python", "-c", WITHOUT_SERVER.format(modules=modules, arguments=list(arguments))
    )


@pytest.mark.parametrize(
    "arguments",
    [
        ["boards"],
        ["drop", "triangle-8", "--seed", "42"],
        ["simulate", "triangle-8", "--drops", "100"],
        ["render", "triangle-8", "--seed", "42", "drop.png"],
        ["payouts", "triangle-8", "--drops", "20000"],
        ["odds"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_physics_pictures_and_commands_need_no_server(
    installed: Installed, arguments: list[str]
) -> None:
    done = without_server(installed, *arguments)
    assert done.returncode == 0, done.stderr


def test_a_session_is_checked_without_the_server(installed: Installed) -> None:
    """Every check passes but one: the sample names the page solver of another build."""
    (installed.folder / "session.json").write_text(
        (ROOT / "tests/golden/session.json").read_text("utf-8"), "utf-8"
    )
    done = without_server(installed, "verify", "session.json")
    assert re.fullmatch(r"not proven: kernel: .*\n", done.stdout), done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["serve"],
        ["relay", "redis://127.0.0.1", "http://127.0.0.1:1"],
        ["ledger", "check"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_command_that_needs_the_server_says_what_to_install(
    installed: Installed, arguments: list[str]
) -> None:
    done = without_server(installed, *arguments)
    assert done.returncode == 2
    assert "pip install 'plinko-sim[server]'" in done.stderr
