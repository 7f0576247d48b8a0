"""The same bits everywhere: machine code and plain Python give the golden digests."""

import json
from pathlib import Path

import pytest

from plinko.engine import PHYSICS_VERSION
from tests.kit.python import ROOT, run_python
from tools.golden import check, make


@pytest.mark.parametrize("name", check.names())
def test_a_drop_has_its_golden_digest(name: str) -> None:
    expected = check.golden()["drops"][name]
    assert check.differences(expected, check.entry(name), name) == []


@pytest.mark.parametrize("name", check.batch_names())
def test_a_thousand_drops_have_their_golden_digest(name: str) -> None:
    expected = check.golden()["batches"][name]
    assert check.differences(expected, check.batch_entry(name), name) == []


def test_the_golden_digests_are_of_this_physics_and_all_boards() -> None:
    golden = check.golden()
    assert golden["physics_version"] == PHYSICS_VERSION
    assert golden["seeds"] == [str(seed) for seed in check.SEEDS]
    assert set(golden["drops"]) == set(check.names())
    assert set(golden["batches"]) == set(check.batch_names())
    digests = [d for entry in golden["drops"].values() for s in check.SOLVERS for d in entry[s]]
    assert len(set(digests)) == len(digests)


def test_a_version_of_the_physics_has_its_entry_in_the_changelog() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    sections = [part for part in changelog.split("\n### ") if part.startswith("Simulation results")]
    assert any(f"`PHYSICS_VERSION` {PHYSICS_VERSION}" in section for section in sections)


def test_plain_python_gives_the_golden_digests() -> None:
    """One drop on every board and scene by both solvers, without the JIT."""
    code = (
        "import sys, plinko.engine.exact.trace as exact\n"
        "assert not hasattr(exact.trace_many, 'function'), 'kernels are compiled'\n"
        "from tools.golden import check\n"
        "sys.exit(check.main(['--quick']))\n"
    )
    printed = run_python(code, NUMBA_DISABLE_JIT="1")
    assert printed.startswith(f"{2 * len(check.batch_names())} drops have the golden digests")


def test_results_cannot_change_behind_the_versions_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """make.py refuses changed digests, unless the version is raised; new boards are accepted."""
    entry = check.golden()["drops"]["triangle-8"]
    old = {"physics_version": 1, "seeds": [], "drops": {"triangle-8": entry}, "batches": {}}
    file = tmp_path / "digests.json"
    monkeypatch.setattr(check, "FILE", file)
    changed = json.loads(json.dumps(old))
    changed["drops"]["triangle-8"]["exact"][0] = "0" * 64
    monkeypatch.setattr(check, "current", lambda: changed)

    file.write_text(json.dumps(old))
    assert make.main([]) == 1
    assert "raise PHYSICS_VERSION first" in capsys.readouterr().out
    assert json.loads(file.read_text()) == old

    changed["physics_version"] = 2
    assert make.main([]) == 0
    assert json.loads(file.read_text()) == changed

    more = json.loads(json.dumps(changed))
    more["drops"]["another"] = entry
    monkeypatch.setattr(check, "current", lambda: more)
    assert make.main([]) == 0
    monkeypatch.setattr(check, "current", lambda: changed)
    assert make.main([]) == 1  # the drops of a removed board would be lost
    assert make.main(["--initial"]) == 0
