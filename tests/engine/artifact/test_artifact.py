"""The artifacts are up to date, small, free of imports, and right to the last bit."""

import gzip
import json
import re
from pathlib import Path

import pytest
import wasmtime

from plinko.engine.artifact import make
from plinko.engine.artifact.sample_calls import SAMPLE_CALLS
from plinko.engine.constants import MAX_TIME
from plinko.engine.exact import event_log, initial_state
from plinko.engine.exact.outcome import MAX_EVENTS
from plinko.engine.jit import source_hash
from plinko.engine.physics import body, contact


@pytest.mark.parametrize("name", make.PAGES)
def test_pages_load_the_engine_s_own_artifact(name: str) -> None:
    assert make.PAGES[name].read_bytes() == (make.FOLDER / f"{name}.wasm").read_bytes()


@pytest.mark.long("it compiles for minutes")
def test_rebuilt_artifacts_are_the_committed_ones() -> None:
    for path, module in make.everything():
        assert path.read_bytes() == module, path.name


@pytest.mark.parametrize("path", [make.FOLDER / f"{n}.wasm" for n in SAMPLE_CALLS])
def test_an_artifact_was_made_from_the_present_kernels(path: Path) -> None:
    made_from = source_hash.read(path.read_bytes())
    assert source_hash.is_of(source_hash.current(), made_from), (
        "kernels have changed since: `make kernels`"
    )


def test_an_artifact_has_every_kernel_that_its_play_calls() -> None:
    """This includes kernels that are called in place, repeatedly on the same arrays."""
    called = make.made_by(
        "from plinko.engine.artifact.sample_calls import SAMPLE_CALLS; "
        "from plinko.engine.artifact.record_types import recorded; "
        "made = ' '.join(recorded(SAMPLE_CALLS['exact'])).encode()"
    )
    said = source_hash.read((make.FOLDER / "exact.wasm").read_bytes())
    assert set(called.decode().split()) == said["calls"].keys()


def test_there_is_no_other_artifact() -> None:
    assert {path.stem for path in make.FOLDER.glob("*.wasm")} == set(SAMPLE_CALLS)


def test_a_change_of_any_kernel_is_noticed(tmp_path: Path) -> None:
    sources = source_hash.sources()
    names = {path.name for path in sources}
    assert {"trace.py", "sampling.py", "circle_impact.py", "contact.py", "grid.py"} <= names
    changed = tmp_path / "trace.py"
    trace = next(path for path in sources if path.name == "trace.py")
    changed.write_bytes(trace.read_bytes() + b"\n")
    others = [changed if path == trace else path for path in sources]
    assert (
        source_hash.hash_of_files(others)
        != source_hash.current()
        == source_hash.hash_of_files(sources)
    )


def test_all_kernels_are_in_the_stamp() -> None:
    uses = re.compile(r"^@(inner_|lean_)?kernel", re.MULTILINE)
    files = {
        p for p in source_hash.ENGINE.rglob("*.py") if uses.search(p.read_text(encoding="utf-8"))
    }
    kernels = {path for path in files if path.parts[-2] not in ("jit", "artifact")}
    assert kernels
    assert kernels <= set(source_hash.sources())


def test_the_artifact_is_small_and_imports_only_memory() -> None:
    module = make.PAGE.read_bytes()
    assert len(gzip.compress(module)) <= make.MOST_GZIPPED
    imports = wasmtime.Module(wasmtime.Engine(), module).imports
    assert [each.name for each in imports] == ["__linear_memory", "__stack_pointer"]
    with pytest.raises(ValueError, match="section 'plinko'"):
        source_hash.read(module[: module.index(b"\x06plinko") - 3])


def test_the_page_has_the_kernels_columns_and_limits() -> None:
    """When `initial` had one column too few, drops overwrote each other and crashed the page."""
    text = make.PAGE.with_suffix(".js").read_text("utf-8")
    found = dict(re.findall(r"^const ([A-Z_]+) = ([^;]+);", text, re.M))
    (start,) = initial_state.in_flight(1).tolist()
    expected = {
        "STATE": body.SIZE,
        "EVENT": event_log.EVENT_SIZE,
        "SEGMENT": event_log.SEGMENT_SIZE,
        "SERIES": [contact.ROWS, contact.ORDER + 1],
        "MAX_EVENTS": MAX_EVENTS,
        "MAX_TIME": MAX_TIME,
        "START": start,
    }
    read = {name: json.loads(found[name].replace("_", "").replace("n", "")) for name in expected}
    assert read == expected
