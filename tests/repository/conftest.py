"""Environments in which the package is installed: from its wheel, and as an editable install."""

import os
import subprocess
import sys
import venv
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
OFFLINE = ["--no-deps", "--no-index"]


@dataclass(frozen=True)
class Installed:
    """An environment, and the wheel or the checkout that is installed in it."""

    source: Path
    folder: Path

    def run(self, *command: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run a program of the environment, without this process's path for modules."""
        environment = {name: v for name, v in os.environ.items() if name != "PYTHONPATH"}
        return subprocess.run(
            [self.folder / "bin" / command[0], *command[1:]],
            cwd=cwd or self.folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    def python(self, code: str, cwd: Path | None = None) -> str:
        done = self.run("python", "-c", code, cwd=cwd)
        assert done.returncode == 0, done.stderr
        return done.stdout


def _install(folder: Path, source: Path, *options: str) -> Installed:
    """Install `source`; its dependencies come from the tests' environment."""
    venv.create(folder, with_pip=False)
    # A .pth file adds this folder, but not what .pth files in it would add, such as the source.
    (site,) = folder.glob("lib/python*/site-packages")
    there = [path for path in sys.path if path.endswith("site-packages")]
    (site / "_dependencies.pth").write_text("\n".join(there) + "\n")
    target = ["--python", str(folder / "bin" / "python"), "install", *OFFLINE, *options]
    subprocess.run([*PIP, *target, str(source)], check=True)
    return Installed(source, folder)


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """The wheel that is built from the source distribution."""
    folder = tmp_path_factory.mktemp("wheel")
    target = ["--target", "sdist", "--directory", str(folder)]
    build = [sys.executable, "-m", "hatchling", "build", *target]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (source,) = folder.glob("*.tar.gz")
    options = [*OFFLINE, "--no-build-isolation", "--wheel-dir", str(folder)]
    subprocess.run([*PIP, "wheel", *options, str(source)], check=True)
    (wheel,) = folder.glob("*.whl")
    return _install(folder / "fresh", wheel)


@pytest.fixture(scope="session")
def editable(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    folder = tmp_path_factory.mktemp("editable")
    return _install(folder / "fresh", ROOT, "--no-build-isolation", "--editable")
