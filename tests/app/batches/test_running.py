"""A batch computed block by block, which can be stopped, killed and resumed."""

import json
import signal
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from plinko.app.batches import saved
from plinko.app.batches.running import SHARE, Run
from plinko.engine import RecordError, drop_many
from plinko.engine.batches.job import Job
from plinko.engine.batches.tally import Tally
from plinko.engine.batches.workers import Here
from plinko.engine.parameters import Exact
from tests.engine.batches.open_board import DROPS, OPEN

JOB = Job(OPEN, Exact(), 0, DROPS)


class Stopping(Here):
    """Compute in this process, and raise `error` after the given number of calls."""

    def __init__(self, after: int, error: type[BaseException]) -> None:
        super().__init__(threads=1)
        object.__setattr__(self, "after", after)
        object.__setattr__(self, "error", error)

    def compute(
        self, work: Callable[[Any, int], Any], asked: Iterable[Any]
    ) -> Iterator[tuple[Any, Any]]:
        for k, found in enumerate(super().compute(work, asked)):
            if k == self.after:  # type: ignore[attr-defined]
                raise self.error  # type: ignore[attr-defined]
            yield found


def ticking() -> Callable[[], float]:
    """A clock that advances by a second each time it is read."""
    times = iter(range(10**6))
    return lambda: float(next(times))


def test_what_is_stopped_goes_on_and_has_the_same_digest(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    run = Run(Tally(JOB), path=path)
    run.compute(Stopping(2, KeyboardInterrupt), run.tally.missing())
    assert run.stopped == signal.SIGINT
    assert run.tally.blocks == [(0, 2)]

    found, seconds = saved.load(path)
    assert found.to_dict() == run.tally.to_dict()
    assert seconds == run.seconds
    again = Run(found, seconds, path)
    again.compute(Here(1), found.missing())
    assert again.stopped is None
    assert found.digest == drop_many(OPEN, range(DROPS)).digest
    assert again.seconds > seconds
    assert [each.name for each in tmp_path.iterdir()] == ["result.json"]


def test_an_error_leaves_what_was_done(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    with pytest.raises(MemoryError):
        Run(Tally(JOB), path=path).compute(Stopping(1, MemoryError), range(3))
    assert saved.load(path)[0].blocks == [(0, 1)]


def test_a_killed_run_has_saved_what_was_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The test reads the file after each block: a killed process would leave just that."""
    path = tmp_path / "result.json"
    kept: list[list[tuple[int, int]]] = []
    run = Run(Tally(JOB), path=path, clock=lambda: 0.0)
    run.compute(Here(1), range(3), lambda _: kept.append(saved.load(path)[0].blocks))
    assert kept == [[(0, 1)], [(0, 2)], [(0, 3)]]


def test_saving_takes_little_of_the_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[int] = []
    monkeypatch.setattr("plinko.app.batches.running.save", lambda *what: written.append(1))
    run = Run(Tally(JOB), path=tmp_path / "result.json", clock=ticking())
    for _ in range(10 * SHARE):
        run._save_if_due()
    assert len(written) == pytest.approx(10, abs=2)


def test_a_file_that_is_no_result_is_named(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    whole = saved.form_of(Tally(JOB), 0.0)
    wrong = (whole | {"seconds": value} for value in (-1, "1", True, None, 1e300))
    texts = (
        "",
        "[]",
        "{}",
        '{"kind": "plinko-batch"}',
        "\0",
        "[" * 200_000,
        "9" * 10**6,
        '{"a": 1, "a": 2}',
    )
    for text in (*texts, *map(json.dumps, wrong)):
        path.write_text(text)
        with pytest.raises(RecordError, match=r"result\.json: "):
            saved.load(path)


def test_a_file_that_is_too_large_is_not_parsed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On Linux /dev/zero never ends."""
    monkeypatch.setattr(saved, "LARGEST", 1000)
    path = tmp_path / "result.json"
    path.write_text(" " * 1001)
    for each in (path, Path("/dev/zero")):
        if each.exists():
            with pytest.raises(RecordError, match=f"{each}: too large"):
                saved.load(each)


def test_the_saved_form_says_seconds_and_rate() -> None:
    run = Run(Tally(Job(OPEN, Exact(), 0, 10)), clock=ticking())
    run.compute(Here(1), [0])
    form = json.loads(json.dumps(saved.form_of(run.tally, run.seconds)))
    assert form["drops_per_second"] == 10 / form["seconds"]
    assert list(form)[-1] == "hashes"
