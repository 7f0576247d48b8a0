"""The artifacts are up to date, small, free of imports, and right to the last bit."""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest

from plinko.engine import Board, drop
from plinko.engine.artifact import make
from plinko.engine.artifact.sample_calls import SAMPLE_CALLS
from plinko.engine.drops.digest import drop_digest
from plinko.engine.drops.trajectory import start_row
from plinko.engine.exact import event_log, initial_state
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.jit import source_hash, wasm_sections
from plinko.engine.physics import body, contact
from tests.engine.artifact.drops import played
from tests.engine.artifact.host import Host

ROOMY = (4096, 16384)  # rows of a log: events and segments, more than most of these drops have


def compare(host: Host) -> int:
    """Compare the drops of `played`; returns how many could be compared."""
    compared = 0
    for board, seeds in played():
        host.load(arrays_of(board))
        for seed in range(seeds):
            done = drop(board, seed)
            start = done.trajectory.start.reshape(1, -1)
            run = host.trace(start, *ROOMY)
            events, segments, impacts = run.counts.tolist()
            if events > len(run.events) or segments > len(run.segments):
                run = host.trace(start, events, segments)
            digest = drop_digest(
                board.digest, done.solver, start_row(done.trajectory), int(run.outcomes[0]),
                run.events[:events], run.marks[:events],
            )  # fmt: skip
            assert digest == done.digest, (board.name, seed)
            assert int(run.impacts[0]) == impacts
            assert run.segments[:segments].tobytes() == done.trajectory.segments.tobytes()
            assert run.states[0].tobytes() == done.trajectory.end.tobytes()
            compared += 1
    return compared


@pytest.mark.long
def test_the_page_s_artifact_gives_the_engine_s_bits() -> None:
    assert compare(Host()) >= 390


@pytest.mark.long("it compiles for a minute")
def test_a_rebuilt_artifact_gives_the_same_bits() -> None:
    assert compare(Host(make.for_pages())) >= 390


@pytest.mark.long("it compiles for minutes")
def test_rebuilt_artifacts_are_the_committed_ones() -> None:
    for path, module in make.everything():
        assert path.read_bytes() == module, path.name


@pytest.mark.parametrize("path", [make.PAGE, *(make.FOLDER / f"{n}.wasm" for n in SAMPLE_CALLS)])
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
    assert {"trace.py", "sampling.py", "circle_impact.py", "contact.py", "entries.py"} <= names
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
    assert wasm_sections.imports(module) == ["env.__linear_memory", "env.__stack_pointer"]
    with pytest.raises(ValueError, match="section 'plinko'"):
        source_hash.read(module[: module.index(b"\x06plinko") - 3])


def test_many_balls_go_as_each_alone() -> None:
    board = Board.preset("triangle-16")
    drops = [drop(board, seed) for seed in range(50)]
    host = Host()
    host.load(arrays_of(board))
    run = host.trace(np.stack([each.trajectory.start for each in drops]))
    assert run.bins.tolist() == [each.bin for each in drops]
    assert run.states[:, 0].tolist() == [each.duration for each in drops]
    assert run.states[:, 1].tolist() == [each.x_end for each in drops]


def test_the_page_leaves_room_for_all_columns_of_the_kernels() -> None:
    """When `initial` had one column too few, drops overwrote each other and crashed the page."""
    text = make.PAGE.with_suffix(".js").read_text("utf-8")
    columns = dict(
        re.findall(r"^const (STATE|EVENT|SEGMENT|INITIAL|SERIES) = ([^;]+);", text, re.M)
    )
    assert columns == {
        "STATE": str(body.SIZE),
        "EVENT": str(event_log.EVENT_SIZE),
        "SEGMENT": str(event_log.SEGMENT_SIZE),
        "INITIAL": str(initial_state.COLUMNS),
        "SERIES": f"{contact.ROWS} * {contact.ORDER + 1}",
    }
