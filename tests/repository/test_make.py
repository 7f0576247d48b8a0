"""The commands of the Makefile: which tests they run, and with what."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDER = "tests/engine/stepped"  # has property tests, which `make check` leaves to `make test`


def commands(*goals: str) -> list[list[str]]:
    """The pytest commands that make runs for these goals, without running them."""
    asked = ["make", "--dry-run", "--no-print-directory", *goals, f"CHECKED={FOLDER}"]
    environment = {name: value for name, value in os.environ.items() if "MAKE" not in name}
    done = subprocess.run(
        asked, cwd=ROOT, env=environment, capture_output=True, text=True, check=True
    )
    lines = done.stdout.replace("\\\n", " ").splitlines()
    return [shlex.split(line) for line in lines if "-m pytest" in line]


def collected(command: list[str], *more: str) -> list[str]:
    """The tests in FOLDER that a command runs, or all with an empty command."""
    options = command[command.index("pytest") + 1 :]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, *more, "--collect-only", "-q", "-n", "0"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return re.findall(rf"^{FOLDER}/\S.*$", done.stdout, re.MULTILINE)


def test_a_test_after_check_runs_what_check_has_left() -> None:
    (check,), (test,) = commands("check"), commands("test", "AFTER=check")
    first, then = collected(check), collected(test, FOLDER)
    assert first
    assert then
    assert sorted(first + then) == sorted(collected(["pytest"], FOLDER))


def test_check_finds_no_program_but_those_of_its_environment() -> None:
    (check,) = commands("check")
    (path,) = [word for word in check if word.startswith("PATH=")]
    assert Path(path.removeprefix("PATH=")) == ROOT / ".venv" / "bin"


def test_continuous_integration_checks_before_npm_installs_anything() -> None:
    lines = re.findall(r"^make (.*)$", (ROOT / ".ci/run").read_text("utf-8"), re.MULTILINE)
    goals = [word for line in lines for word in line.split() if word[0] != "-"]
    assert goals[:2] == ["check", "node_modules/.stamp"]
    assert sorted(goals[3:]) == ["AFTER=check", "docs", "lint", "test", "test-servers"]
