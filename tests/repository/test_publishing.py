"""Publishing: the workflows, the citation, and the site's pages."""

import json
import re
import shutil
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import nbformat
import pytest
import yaml
from nbclient import NotebookClient

from plinko.engine import Board, drop, drop_many
from tests.repository.test_repository import PROJECT, ROOT

WORKFLOWS = {path.name: path for path in (ROOT / ".github" / "workflows").glob("*.yml")}
DOCS = ROOT / "docs"


def loaded(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def steps(workflow: Any) -> list[dict[str, Any]]:
    return [step for job in workflow["jobs"].values() for step in job.get("steps", ())]


# Workflows. `make lint` checks them against their host's schema.


@pytest.mark.parametrize("path", WORKFLOWS.values(), ids=WORKFLOWS)
def test_a_workflow_pins_its_actions_and_limits_its_rights(path: Path) -> None:
    workflow = loaded(path)
    used = [step["uses"] for step in steps(workflow) if "uses" in step]
    assert used
    assert [use for use in used if not re.fullmatch(r"[\w.-]+/[\w./-]+@v\d+(\.\d+)*", use)] == []
    assert workflow["permissions"] == {"contents": "read"}, "more is for single jobs"
    assert all("timeout-minutes" in job for job in workflow["jobs"].values() if "uses" not in job)


def test_nothing_is_published_that_was_not_checked() -> None:
    workflow = loaded(WORKFLOWS["publish.yml"])
    jobs = workflow["jobs"]
    assert jobs["check"]["uses"] == "./.github/workflows/check.yml"
    assert "workflow_call" in loaded(WORKFLOWS["check.yml"])[True]  # YAML 1.1 reads `on` as true
    assert set(jobs["pypi"]["needs"]) == {"check", "build"}
    assert jobs["image"]["needs"] == "check"
    assert set(jobs["constraints"]["needs"]) == {"check", "build"}
    assert jobs["pypi"]["permissions"] == {"id-token": "write"}, "no token is kept"
    assert {"linux/${{ matrix.platform }}"} == {
        step["with"]["platforms"]
        for step in jobs["image"]["steps"]
        if "build-push" in step.get("uses", "")
    }


def test_both_packages_are_published_with_the_repository_s_address(tmp_path: Path) -> None:
    for name in ("tools/set-urls", "pyproject.toml", "npm/package.json"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    url = "https://git.example/plinko/plinko"
    subprocess.run([tmp_path / "tools/set-urls", url], check=True)
    urls = tomllib.loads((tmp_path / "pyproject.toml").read_text("utf-8"))["project"]["urls"]
    package = json.loads((tmp_path / "npm/package.json").read_text("utf-8"))
    assert (urls["Source"], package["repository"]["url"]) == (url, f"git+{url}.git")
    assert package["name"] == PROJECT["project"]["name"]
    jobs = loaded(WORKFLOWS["publish.yml"])["jobs"]
    for job in ("build", "npm"):
        runs = [step.get("run", "").split()[0] for step in jobs[job]["steps"] if "run" in step]
        assert "tools/set-urls" in runs, job


# The citation.


def test_the_citation_has_the_license_and_the_authors() -> None:
    citation = loaded(ROOT / "CITATION.cff")
    assert citation["license"] == PROJECT["project"]["license"]
    assert [one["name"] for one in citation["authors"]] == [
        one["name"] for one in PROJECT["project"]["authors"]
    ]


# The site. `make docs` fails on a page without an entry in the contents, and on a broken link.


def test_the_pages_own_example_runs_as_it_stands() -> None:
    page = (DOCS / "python.md").read_text(encoding="utf-8")
    examples = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {}
    for code in examples:
        exec(compile(code.replace("100_000", "1_000"), "python.md", "exec"), names)
    assert names["d"] == drop("triangle-16", 42)
    assert names["batch"] == drop_many("triangle-16", range(1000))


def test_a_board_is_made_in_python_as_its_page_says() -> None:
    page = (DOCS / "boards.md").read_text(encoding="utf-8")
    obstacle, prizes = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(obstacle, "boards.md", "exec"), names)
    assert len(names["board"].walls) == len(Board.triangle(6).walls) + 3
    exec(compile(prizes, "boards.md", "exec"), names)
    assert names["board"].bins.label_of(8) == "Mug"


# The tutorial.

TUTORIAL = DOCS / "tutorial.ipynb"


def tutorial() -> nbformat.NotebookNode:
    return nbformat.read(TUTORIAL, as_version=4)  # type: ignore[no-untyped-call,no-any-return]


def test_the_tutorial_is_kept_without_what_it_prints() -> None:
    kept = tutorial()
    nbformat.validate(kept)
    for cell in kept.cells:
        assert cell.metadata == {}
        if cell.cell_type == "code":
            assert (cell.outputs, cell.execution_count) == ([], None)
    text = json.dumps(json.loads(TUTORIAL.read_text()), indent=1, ensure_ascii=False)
    assert TUTORIAL.read_text() == f"{text}\n"


async def test_the_tutorial_goes_from_a_drop_to_a_histogram_to_chaos() -> None:
    told = tutorial()
    client = NotebookClient(told, kernel_name="python3", timeout=None)
    client.create_kernel_manager().transport = "ipc"
    await client.async_execute()
    outputs = [output for cell in told.cells for output in cell.get("outputs", ())]
    shown = [output.data for output in outputs if "data" in output]
    board = Board.preset("triangle-16")
    drawn = [data["text/plain"] for data in shown if "<svg" in data.get("text/html", "")]
    assert drawn == [
        repr(value)
        for value in (board, drop(board, 42), drop_many(board, range(20_000)), drop(board, 7))
    ]
    assert any("image/png" in data for data in shown), "the distance of two balls, plotted"
    said = "".join(output.text for output in outputs if output.output_type == "stream")
    assert "impacts on pegs, each by a factor of" in said
    assert [output for output in outputs if output.get("name") == "stderr"] == []
