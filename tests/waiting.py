"""Waiting for processes, with an end: what a server has not said by then it never will."""

import select
import subprocess
from typing import AnyStr

import pytest

LIMIT = 120.0
"""s without a word after which a test has failed, on however slow a machine.

A server may have to compile the physics before it says where it is.
"""


def first_line(process: "subprocess.Popen[AnyStr]") -> AnyStr:
    """What a server says once it can be used; ends it and fails when nothing comes."""
    assert process.stdout is not None
    if not select.select([process.stdout], [], [], LIMIT)[0]:
        process.kill()
        pytest.fail(f"process {process.args!r} said nothing within {LIMIT:.0f} s")
    return process.stdout.readline()
