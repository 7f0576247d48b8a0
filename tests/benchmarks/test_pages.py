"""Measurements are recorded once, and pages show exactly what is recorded."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks import __main__ as main_module
from benchmarks import suite
from benchmarks.__main__ import main
from benchmarks.harness import pages, recorded
from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.recorded import DOCS, IMAGES
from benchmarks.harness.report import Section, Table
from benchmarks.scale import estimates

TABLE = Table("Speed on 2 cores", ["who", "s", "m"], [["a", "1", "2"], ["b", "3", "4"]], ["Why."])
MACHINE = {
    "processor": "P",
    "cores": "2",
    "system": "S",
    "python": "3",
    "numpy": "2",
    "load": "0.1",
}


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """A folder with one recorded file, of the benchmark `drop`."""
    recorded.write(Section("drop", [TABLE]), MACHINE, 3.0, tmp_path / "measured")
    return tmp_path / "measured"


def shown(comment: str, folder: Path) -> str:
    text = f"Words.\n<!-- table {comment} -->\nold\n<!-- /table -->\nMore.\n"
    return pages.filled(text, folder.parent, folder)


def test_a_page_keeps_its_words_and_shows_the_table(measured: Path) -> None:
    text = shown("drop: Speed", measured)
    assert text.startswith("Words.\n<!-- table drop: Speed -->\n")
    assert "[Speed on 2 cores](measured/drop.json):\n\n| who |" in text
    assert text.endswith("<!-- /table -->\nMore.\n")
    assert "old" not in text
    assert pages.filled(text, measured.parent, measured) == text


def test_the_site_draws_the_table_in_place_of_its_comment(measured: Path) -> None:
    text = pages.drawn("Words.\n<!-- table drop: Speed | rows: b -->\nMore.\n", DOCS, measured)
    assert text.startswith("Words.\n[Speed on 2 cores](")
    assert text.endswith("| b   | 3 | 4 |\nMore.\n")


def test_a_page_may_show_some_rows_and_columns_in_its_own_order(measured: Path) -> None:
    text = shown("drop: Speed | rows: b; a | columns: m", measured)
    lines = [line.replace(" ", "") for line in text.splitlines() if line.startswith("|")]
    assert lines == ["|who|m|", "|---|:|", "|b|4|", "|a|2|"]


@pytest.mark.parametrize("choice", ["rows: c", "columns: x"])
def test_a_row_or_a_column_that_is_not_recorded_is_named(choice: str, measured: Path) -> None:
    with pytest.raises(MissingError, match=r"'Speed' has no \['[cx]'\]"):
        shown(f"drop: Speed | {choice}", measured)


@pytest.mark.parametrize(("name", "title"), [("drop", "Slow"), ("other", "Speed")])
def test_a_page_says_which_table_is_not_measured_yet(name: str, title: str, measured: Path) -> None:
    text = shown(f"{name}: {title}", measured)
    assert f"*Not measured yet: `python -m benchmarks {name} --record`.*" in text


def test_the_site_shows_each_record_with_its_machine_and_plots(measured: Path) -> None:
    text = recorded.site_text(measured)
    assert text.startswith("## drop\n\nBy `python -m benchmarks drop` in 3 s, on: processor P, ")
    assert text.endswith("| b   | 3 | 4 |\n\nWhy.")


def test_a_file_has_a_line_for_each_row(measured: Path) -> None:
    text = (measured / "drop.json").read_text()
    assert '    ["a", "1", "2"],\n    ["b", "3", "4"]\n' in text


def test_the_readme_and_the_estimates_are_as_recorded() -> None:
    told = "python -m benchmarks pages writes it"
    assert estimates.FILE.read_text(encoding="utf-8") == estimates.record(), told
    text = pages.README.read_text(encoding="utf-8")
    assert pages.filled(text, pages.README.parent) == text, told


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda page: page.name)
def test_the_site_draws_every_table_that_a_page_names(page: Path) -> None:
    text = pages.drawn(page.read_text(encoding="utf-8"), DOCS)
    assert "<!-- table" not in text
    assert "*Not measured yet" not in text


def test_every_plot_that_is_kept_is_recorded() -> None:
    kept = sorted(path.name for path in IMAGES.glob("bench-*.png"))
    assert kept
    assert [name for name in kept if f"](images/{name})" not in recorded.site_text()] == []


def test_a_benchmark_prints_and_records(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def measure(name: str, effort: Effort) -> Section:
        assert (effort.quick, effort.rounds) == (False, 2)
        if name == "relays":
            raise MissingError("no Redis here")
        return Section(name, [TABLE], plots={"plot.png": lambda path: Path(path).touch()})

    monkeypatch.setattr(suite, "run", measure)
    monkeypatch.setattr(recorded, "FOLDER", tmp_path / "measured")
    monkeypatch.setattr(recorded, "IMAGES", tmp_path / "images")
    monkeypatch.setattr(main_module, "_fill", lambda: None)
    options = ["--rounds", "2", "--record"]
    done = CliRunner().invoke(main, ["drop", *options])
    assert "## Speed on 2 cores" in done.stdout
    assert recorded.site_text(tmp_path / "measured").endswith("![plot](images/plot.png)")
    assert (tmp_path / "images" / "plot.png").exists()
    everything = CliRunner().invoke(main, ["all", *options])
    assert everything.exit_code == 1
    assert "not measured: relays: no Redis here" in everything.stderr
    files = {file.stem for file in (tmp_path / "measured").iterdir()}
    assert files == set(suite.BENCHMARKS) - {"relays"}


def test_a_quick_run_is_not_recorded() -> None:
    for name in ("drop", "all"):
        done = CliRunner().invoke(main, [name, "--quick", "--record"])
        assert done.exit_code == 2
        assert "not recorded" in done.stderr


def test_the_help_names_every_benchmark_with_its_question() -> None:
    text = CliRunner().invoke(main, ["--help"]).stdout
    for name, benchmark in suite.BENCHMARKS.items():
        assert f"  {name} " in text
        assert benchmark.question in text
