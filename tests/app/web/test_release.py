"""A page's modules as one script, and its styles as one sheet."""

import json
import re
import subprocess
from pathlib import Path

import pytest

from app.web.release import parts, script, sheet

STATIC = Path(__file__).parents[3] / "static"


def written(folder: Path, **modules: str) -> Path:
    for name, text in modules.items():
        (folder / f"{name}.js").write_text(text)
    return folder


def test_one_script_does_what_its_modules_do(tmp_path: Path) -> None:
    written(
        tmp_path,
        main='import { two as second, one } from "./numbers.js";\n'
        'import * as all from "./passed.js";\n'
        "console.log(JSON.stringify([one, second(), all.one]));\n",
        numbers="// One and two.\n\nexport const one = 1;\n"
        "export function two() {\n  return one + 1;\n}\n",
        passed='export { one } from "./numbers.js";\n',
    )
    (tmp_path / "all.mjs").write_text(script(tmp_path, "main.js"))
    told = subprocess.run(["node", tmp_path / "all.mjs"], capture_output=True, check=True)
    assert json.loads(told.stdout) == [1, 2, 1]


def test_a_comment_ends_where_it_ends(tmp_path: Path) -> None:
    """What followed one that stands before code was taken for a part of it, up to the next."""
    written(
        tmp_path,
        main="export const one = (\n  /** @type {any} */ (1)\n);\n/** Two. */\nconsole.log(one);\n",
    )
    (tmp_path / "all.mjs").write_text(script(tmp_path, "main.js"))
    told = subprocess.run(["node", tmp_path / "all.mjs"], capture_output=True, check=True)
    assert told.stdout == b"1\n"


def test_an_export_without_a_name_is_refused_with_its_file(tmp_path: Path) -> None:
    written(tmp_path, main="export default 7;\n")
    with pytest.raises(ValueError, match=r"main\.js has 'export default 7;'"):
        script(tmp_path, "main.js")


def test_what_lies_beside_a_module_is_found_from_where_the_script_lies() -> None:
    whole = script(STATIC, "js/play/main.js")
    beside = re.findall(r'new URL\("([^"]+)", import\.meta\.url\)', whole)
    assert "../solver/kernels.wasm" in beside
    assert all((STATIC / "js/play" / path).is_file() for path in beside)


@pytest.mark.parametrize("page", sorted(path.name for path in STATIC.glob("*.html")))
def test_every_page_has_one_script_and_one_sheet(page: str) -> None:
    text, made = parts(STATIC, page, (STATIC / page).read_text())
    named = re.findall(r'<(?:script|link rel="stylesheet")[^>]* (?:src|href)="([^"]+)"', text)
    assert sorted(named) == sorted(made)
    assert len(made) == 2


def test_a_sheet_begins_with_the_colours_of_both_schemes() -> None:
    theme = json.loads((STATIC / "theme.json").read_text())
    told = sheet(STATIC, ["css/base.css"])
    light, dark = re.findall(r"--page-deep: (#\w+);", told)
    assert (light, dark) == (theme["light"]["pageDeep"], theme["dark"]["pageDeep"])
    assert told.index("prefers-color-scheme: dark") < told.index("--touch")
