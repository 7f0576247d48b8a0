"""The golden digests on an emulated arm64 processor: by wasmtime, and as Python runs kernels."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tools.golden import check


@pytest.mark.long("it takes minutes, and packages from the network")
@pytest.mark.skipif(shutil.which("apt-get") is None, reason="it is made of Debian's packages")
@pytest.mark.timeout(3600)
def test_the_artifacts_give_the_golden_digests_on_arm64() -> None:
    done = subprocess.run(
        [Path(__file__).with_name("check"), sys.executable],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    system, by_artifacts, by_native_code, as_python = done.stdout.splitlines()
    assert "aarch64" in system
    drops = len(check.names()) * len(check.SOLVERS) * len(check.SEEDS)
    assert by_artifacts == f"{drops} drops have the golden digests"
    assert by_native_code == "native code of 2 kernels has the same bits"
    quick = len(check.batch_names()) * len(check.SOLVERS)
    assert as_python == f"{quick} drops have the golden digests"
