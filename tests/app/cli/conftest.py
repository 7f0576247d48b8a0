"""The command line in the tests' process."""

import json
from typing import Any

import pytest

from plinko.app.cli import main


class Terminal:
    """Runs commands in this process and captures their output."""

    def __init__(self, capture: pytest.CaptureFixture[str]) -> None:
        self._capture = capture

    def try_run(self, *arguments: object) -> tuple[int, str, str]:
        """The exit code, the output, and what the command said on stderr."""
        code = main([str(argument) for argument in arguments])
        return code, *self._capture.readouterr()

    def run(self, *arguments: object) -> str:
        """Run a command that must succeed and print nothing on stderr; returns its output."""
        code, out, err = self.try_run(*arguments)
        assert (code, err) == (0, "")
        return out

    def json(self, *arguments: object) -> Any:
        out = self.run(*arguments, "--json")
        assert out.count("\n") == 1
        return json.loads(out)

    def refuses(self, *arguments: object) -> str:
        """Run a command that must end with 2 and one line on stderr; returns that line."""
        code, out, err = self.try_run(*arguments)
        assert (code, out, err.count("\n")) == (2, "", 1), err
        assert err.startswith("plinko: ")
        return err


@pytest.fixture
def plinko(capsys: pytest.CaptureFixture[str]) -> Terminal:
    return Terminal(capsys)
