"""The tests of the pages' pure modules."""

import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ALONE = HERE / "play" / "game.test.js"  # it replaces the clock and the chance of its process


@pytest.mark.long
@pytest.mark.parametrize(
    "files", [sorted({*HERE.rglob("*.test.js")} - {ALONE}), [ALONE]], ids=["most", "game"]
)
def test_the_modules_pass_their_tests_in_one_process_of_node(files: list[Path]) -> None:
    script = "".join(f'import "{file.as_uri()}";' for file in files)
    command = ["node", "--test-reporter=spec", "--input-type=module", "--eval", script]
    ran = subprocess.run(command, cwd=HERE.parents[1], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, (
        ran.stdout.partition("failing tests:")[2] or ran.stdout,
        ran.stderr,
    )
