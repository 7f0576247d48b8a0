"""Bundling: a page's modules become one script, and its styles one sheet."""

import json
import re
import subprocess
from pathlib import Path

import pytest

from plinko.app.web.page.languages import languages_of
from plinko.app.web.page.release import assembled, parts, script, sheet
from tests.app.web.page.site import STATIC, site


def written(folder: Path, **modules: str) -> Path:
    for name, text in modules.items():
        (folder / f"{name}.js").write_text(text)
    return folder


def ran(folder: Path, code: str) -> str:
    """What this module prints in Node.js, which runs it in `folder`."""
    (folder / "package.json").write_text('{"type": "module"}')
    command = ["node", "--input-type=module"]
    done = subprocess.run(
        command, input=code, cwd=folder, capture_output=True, check=True, encoding="utf-8"
    )
    return done.stdout


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
    assert ran(tmp_path, script(tmp_path, "main.js")) == "[1,2,1]\n"


def test_comments_are_removed_and_what_looks_like_one_is_kept(tmp_path: Path) -> None:
    written(
        tmp_path,
        main='const where = "a // b"; // it\'s a "place"\n'
        "const there = `${where} // c`; // `there`\n"
        'const quoted = /["]/.test(where); // no "\n'
        "const tall = `d\n  // e`;\n"
        # A bug took the code after a comment for a part of it, up to the next comment.
        "const one = (\n  /** @type {any} */ (1)\n);\n/** Two. */\n"
        "console.log([where, there, 8 / 2 / 2, quoted, tall, one].join()); // http://a // twice\n",
    )
    text = script(tmp_path, "main.js")
    assert not [each for each in ("place", "`there`", "http://a") if each in text]
    assert ran(tmp_path, text) == "a // b,a // b // c,2,false,d\n  // e,1\n"


@pytest.mark.parametrize(
    ("main", "said"),
    [
        ("export default 7;\n", "'export default 7;'"),
        # These would be loaded unbundled, with all their imports, and in English.
        ("await import(`./later.js`);\n", r"'await import\(.*in quotes"),
        ('await import(new URL("a.js", import.meta.url).href);\n', r"'await import\(.*in quotes"),
    ],
)
def test_an_export_without_a_name_and_a_computed_import_are_refused(
    main: str, said: str, tmp_path: Path
) -> None:
    written(tmp_path, main=main)
    with pytest.raises(ValueError, match=rf"main\.js has {said}"):
        script(tmp_path, "main.js")


def test_a_file_next_to_a_module_is_found_from_the_script() -> None:
    whole = script(STATIC, "js/play/main.js")
    beside = re.findall(r'new URL\("([^"]+)",import\.meta\.url\)', whole)
    assert "../solver/kernels.wasm" in beside
    beside.remove("../../../sw.js")  # next to the release, as its scope is all pages
    assert all((STATIC / "js/play" / path).is_file() for path in beside)


@pytest.mark.parametrize("page", sorted(path.name for path in STATIC.glob("*.html")))
def test_every_page_has_one_script_and_one_sheet_which_goes_first(page: str) -> None:
    languages = languages_of(STATIC)
    pages, made = parts(STATIC, page, (STATIC / page).read_text(), languages)
    every = set()
    for text in pages.values():
        named = re.findall(r'<(?:script|link rel="stylesheet")[^>]* (?:src|href)="([^"]+)"', text)
        assert len(named) == (1 if page == "404.html" else 2)  # 404.html has no script
        every |= set(named)
        assert text.count('fetchpriority="low"') == text.count("<script")
        assert 'rel="preload"' not in text
    later = set(made) - every  # scripts that the page's script fetches
    assert every <= set(made)
    assert all(any(Path(path).name in code for code in made.values()) for path in later)
    scripts = json.dumps([code for path, code in made.items() if path.endswith(".js")])
    parse = 'JSON.parse(require("fs").readFileSync(0)).forEach((t) => new vm.SourceTextModule(t))'
    subprocess.run(
        ["node", "--experimental-vm-modules", "-e", parse], input=scripts, text=True, check=True
    )


def test_a_later_module_shares_what_the_page_has_loaded(tmp_path: Path) -> None:
    (tmp_path / "js/texts").mkdir(parents=True)
    for language, words in (("en", "Yes No Perhaps"), ("de", "Ja Nein Vielleicht")):
        keys = dict(zip(["a.yes", "a.no", "a.perhaps"], words.split(), strict=True))
        (tmp_path / f"js/texts/{language}.json").write_text(json.dumps(keys))
    written(
        tmp_path / "js",
        text='import texts from "./texts/en.json" with { type: "json" };\n'
        "export const t = (key) => texts[key];\n",
        state="export const met = [];\n",
        last='import { met } from "./state.js";\nimport { t } from "./text.js";\n'
        'export const end = () => met.push(t("a.perhaps"));\n',
        later='import { met } from "./state.js";\nimport { t } from "./text.js";\n'
        'export async function go() {\n  met.push(t("a.no"));\n'
        '  const { end } = await import("./last.js");\n  end();\n}\n',
        main='import { met } from "./state.js";\nimport { t } from "./text.js";\n'
        'met.push(t("a.yes"));\n'
        'const loading = import("./later.js").then(({ go }) => go());\n'
        "loading.then(() => console.log(met.join()));\n",
    )
    page = '<script type="module" src="js/main.js"></script>'
    pages, made = parts(tmp_path, "index.html", page, languages_of(tmp_path))
    for path, code in made.items():
        (tmp_path / path).write_text(code)
    said = [ran(tmp_path, f"import './js/all.{language}.js'") for language in pages]
    assert said == ["Yes,No,Perhaps\n", "Ja,Nein,Vielleicht\n"]
    assert "Nein" not in made["js/all.de.js"]
    assert "Ja" not in made["js/later-index.de.js"]


def test_a_module_that_two_pages_load_later_starts_neither_of_them(tmp_path: Path) -> None:
    (tmp_path / "js").mkdir()
    written(
        tmp_path / "js",
        state="export const said = [];\n",
        later='import { said } from "./state.js";\nexport const end = () => said.join();\n',
    )
    for name in ("one", "two"):
        (tmp_path / "js" / name).mkdir()
        main = f'import {{ said }} from "../state.js";\nsaid.push("{name}");\n'
        main += 'void import("../later.js").then(({ end }) => console.log(end()));\n'
        (tmp_path / "js" / name / "main.js").write_text(main)
        page = f'<script type="module" src="js/{name}/main.js"></script>'
        for path, code in parts(tmp_path, f"{name}.html", page, {"en": {}})[1].items():
            (tmp_path / path).write_text(code)
    for name in ("one", "two"):
        assert ran(tmp_path, f"import './js/{name}/all.en.js'") == f"{name}\n"


def test_a_module_is_not_loaded_both_at_once_and_later(tmp_path: Path) -> None:
    (tmp_path / "js").mkdir()
    written(
        tmp_path / "js",
        other="export const one = 1;\n",
        main='import { one } from "./other.js";\nvoid import("./other.js");\nvoid one;\n',
    )
    page = '<script type="module" src="js/main.js"></script>'
    with pytest.raises(ValueError, match=r"js/main\.js imports js/other\.js later"):
        parts(tmp_path, "index.html", page, {"en": {}})


def test_a_script_has_its_language_s_texts_that_it_names_only(tmp_path: Path) -> None:
    (tmp_path / "js/texts").mkdir(parents=True)
    for language, said in (("en", "Yes"), ("de", "Ja")):
        (tmp_path / f"js/texts/{language}.json").write_text(
            json.dumps({"yes": said, "other": f"{said} {said}"})
        )
    main = 'import texts from "./texts/en.json" with { type: "json" };\n'
    main += 'console.log(JSON.stringify(texts), "yes");\n'
    (tmp_path / "js/main.js").write_text(main)
    page = '<p>{{other}}</p><script type="module" src="js/main.js"></script>'
    pages, made = parts(tmp_path, "index.html", page, languages_of(tmp_path))
    assert pages["de"].startswith("<p>Ja Ja</p>")
    assert ran(tmp_path, made["js/all.de.js"]) == '{"yes":"Ja"} yes\n'


def test_numbers_are_written_as_in_the_script_s_language(tmp_path: Path) -> None:
    page = '<script type="module" src="js/util/format.js"></script>'
    _, made = parts(STATIC, "index.html", page, languages_of(STATIC))
    said = {}
    for language in ("en", "de", "es"):
        asked = "const { amount, multiplier, percent, signed } = m_js_util_format_js;\n"
        asked += "console.log([amount(12345.6), multiplier(1.5), percent(0.931), signed(-0.5)]"
        asked += ".join(' '));\n"
        said[language] = ran(tmp_path, made[f"js/util/all.{language}.js"] + asked).strip()
    assert said == {
        "en": "12,345.60 1.5x 93.1 % −0.50",
        "de": "12.345,60 1,5x 93,1 % −0,50",
        "es": "12.345,60 1,5x 93,1 % −0,50",
    }


async def test_a_page_begins_in_the_colours_that_its_visitor_chose() -> None:
    async with site() as pages:
        marks = set()
        for scheme in ("dark", "light"):
            answer = await pages.get("/", headers={"cookie": f"scheme={scheme}"})
            assert f'<html data-scheme="{scheme}" lang=' in answer.text
            marks.add(answer.headers["etag"])
        for other in ("scheme=system", 'scheme="><b>', ""):
            answer = await pages.get("/", headers={"cookie": other})
            assert "data-scheme" not in answer.text
            marks.add(answer.headers["etag"])
        assert len(marks) == 3


async def test_only_a_browser_is_shown_a_page_where_none_exists() -> None:
    async with site() as pages:
        browser = {"accept": "text/html,*/*;q=0.8", "accept-language": "de"}
        answer = await pages.get("/no/such/page", headers=browser)
        assert answer.status_code == 404
        assert "Diese Kugel ging am Brett vorbei." in answer.text
        for path, accept in (("/no/such/page", "*/*"), ("/api/v1/none", browser["accept"])):
            program = await pages.get(path, headers={"accept": accept})
            assert program.status_code == 404
            assert "<html" not in program.text


async def test_links_to_proofs_are_hidden_where_the_server_has_none() -> None:
    hides = ':root[data-proofs="none"] .proofs {\n  display: none !important;'
    assert hides in (STATIC / "css/base.css").read_text()
    for proofs in (True, False):
        async with site(proofs=proofs) as pages:
            text = (await pages.get("/replay.html")).text
            assert ('data-proofs="none"' in text) is not proofs
            assert len(re.findall(r'class="[^"]*\bproofs\b', text)) == 3


def test_a_sheet_begins_with_the_colours_of_both_schemes() -> None:
    theme = json.loads((STATIC / "theme.json").read_text())
    told = sheet(STATIC, ["css/base.css"])
    light, dark = theme["light"]["pageDeep"], theme["dark"]["pageDeep"]
    # Light; dark if the system is dark and light is not chosen; dark if dark is chosen.
    assert re.findall(r"--page-deep:(#\w+)", told) == [light, dark, dark]
    assert told.index("prefers-color-scheme:dark") < told.index("--touch")


def test_shared_parts_have_each_page_s_texts_and_current_link(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/top.part").write_text("<h1>{{$title}}</h1>\n  {{> nav}}\n")
    links = '<a href="./">1</a><a href="two.html">2</a>\n'
    (tmp_path / "parts/nav.part").write_text(links)
    text = "<body>\n  {{> top title=two.title}}\n</body>\n"
    marked = '<a href="./">1</a><a href="two.html" aria-current="page">2</a>\n'
    told = assembled(tmp_path, "two.html", text)
    assert told == f"<body>\n<h1>{{{{two.title}}}}</h1>\n{marked}</body>\n"
    assert '<a href="./" aria-current="page">' in assembled(tmp_path, "index.html", text)
