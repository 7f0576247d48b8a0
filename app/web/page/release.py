"""Bundles each page: all its modules as one script and its styles as one sheet, in each language.

A page on a slow connection then waits for two files only.

HTML that all pages share is in parts/<name>.part. A page includes it with
`{{> head title=map.title}}`, and the part has `{{$title}}` where the page's text goes.

The bundle does not transpile or rename anything. Each module becomes a function that returns its
exports, after the modules that it imports. Comments and blanks are removed, and the English texts
are replaced by those of one language (languages.py).

A module that a page fetches later, by `import(new URL("…", import.meta.url).href)`, is bundled in
the same way if it has texts.
"""

import json
import posixpath
import re
from collections.abc import Mapping
from pathlib import Path

from rcssmin import cssmin
from rjsmin import jsmin

from plinko.app.web.page.languages import ENGLISH, Texts, filled, path_of, used_in

_IMPORT = re.compile(
    r'^import\s+(?:\{(?P<names>[^}]*)\}|\*\s+as\s+(?P<space>\w+))\s+from\s+"(?P<path>[^"]+)";$',
    re.M,
)
_REEXPORT = re.compile(r'^export\s+\{(?P<names>[^}]*)\}\s+from\s+"(?P<path>[^"]+)";$', re.M)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function\*?|class|const) (\w+))", re.M)
_DATA = re.compile(r'^import (?P<name>\w+) from "(?P<path>[^"]+)" with \{ type: "json" \};$', re.M)
_LEFT = re.compile(r"^(?:import|export)\b.*$", re.M)
_BESIDE = re.compile(r'new URL\("([^"]+)", import\.meta\.url\)')
_LATER = re.compile(r'import\(new URL\("([^"]+)",\s*import\.meta\.url\)\.href\)')
_RETURNED = re.compile(r"return\s*\{([^}]*)\};?\s*\}\)\(\);\s*$")
_SHEET = re.compile(r'    <link rel="stylesheet" href="(css/[^"]+)">\n')
# css/base.css hides the page until a script has set the colours. The bundled sheet has the colours,
# so it shows the page at once.
_SHOWN = 'html:not([style*="--page"]) body {\n  visibility: visible;\n}\n'
_PART = re.compile(r"^ *\{\{> (\w+)((?: \w+=[\w.-]+)*)\}\}\n", re.M)
_SCRIPT = re.compile(r'<script type="module" src="(js/[^"]+)">')


def script(static: Path, entry: str) -> str:
    """The module at `entry` (a path below `static`) and all its imports, as one module.

    Raises ValueError for a form of import or export that the bundler does not know.
    """
    return "".join(_modules(static, entry).values())


def _modules(static: Path, entry: str) -> dict[str, str]:
    """The bundled code of each module by path, imported modules before those that import them."""
    modules: dict[str, str] = {}
    _add(static, entry, posixpath.dirname(entry), modules)
    return modules


def _add(static: Path, path: str, home: str, modules: dict[str, str]) -> None:
    text = (static / path).read_text(encoding="utf-8")
    modules[path] = ""  # marks it as visited, for an import in a circle
    exports = _EXPORT.findall(text)

    def beside(named: str) -> str:
        return posixpath.normpath(posixpath.join(posixpath.dirname(path), named))

    def imported(found: "re.Match[str]") -> str:
        source = beside(found["path"])
        if source not in modules:
            _add(static, source, home, modules)
        if found.groupdict().get("space"):
            return f"const {found['space']} = {_name(source)};"
        return f"const {{{found['names'].replace(' as ', ': ')}}} = {_name(source)};"

    def passed_on(found: "re.Match[str]") -> str:
        exports.extend(name.strip() for name in found["names"].split(",") if name.strip())
        return imported(found)

    def data(found: "re.Match[str]") -> str:
        source = beside(found["path"])
        modules.setdefault(source, _constant(source, (static / source).read_text("utf-8").strip()))
        return f"const {found['name']} = {_name(source)};"

    text = _DATA.sub(data, text)
    text = _IMPORT.sub(imported, text)
    text = _REEXPORT.sub(passed_on, text)
    text = _EXPORT.sub("", text)
    strange = _LEFT.search(text)
    if strange:
        raise ValueError(
            f"{path} has {strange[0]!r}, which the bundler does not know: import and export by name"
        )
    text = _BESIDE.sub(
        lambda found: f'new URL("{posixpath.relpath(beside(found[1]), home)}", import.meta.url)',
        text,
    )
    modules.pop(path)
    gives = f"return {{ {', '.join(exports)} }};"
    code = jsmin(f"const {_name(path)} = (() => {{\n{text}{gives}\n}})();")
    modules[path] = f"// {path}\n{code}\n"


def _constant(path: str, value: str) -> str:
    return f"const {_name(path)} = {value};\n"


def _name(path: str) -> str:
    return "m_" + re.sub(r"\W", "_", path)


def sheet(static: Path, styles: list[str]) -> str:
    """One style sheet: the colours of theme.json, then these sheets."""
    theme = json.loads((static / "theme.json").read_text(encoding="utf-8"))
    unless_light = _colours(theme["dark"], ':root:not([data-scheme="light"])')
    dark = f"@media (prefers-color-scheme: dark) {{\n{unless_light}}}\n"
    dark += _colours(theme["dark"], ':root[data-scheme="dark"]')  # set for visitors who chose it
    texts = [(static / style).read_text(encoding="utf-8") for style in styles]
    whole = "".join([_colours(theme["light"], ":root"), dark, *texts, _SHOWN])
    return str(cssmin(whole))


def _colours(palette: dict[str, str], selector: str) -> str:
    lines = [f"  --{_kebab(name)}: {colour};\n" for name, colour in palette.items()]
    return "".join([f"{selector} {{\n", *lines, "}\n"])


def _kebab(name: str) -> str:
    return re.sub("[A-Z]", lambda big: f"-{big[0].lower()}", name)


def assembled(static: Path, page: str, text: str) -> str:
    """The HTML of `page` with its shared parts; a link to the page itself is `aria-current`."""

    def part(found: "re.Match[str]") -> str:
        given = dict(each.split("=") for each in found[2].split())
        shared = (static / f"parts/{found[1]}.part").read_text("utf-8")
        for name, key in given.items():
            shared = shared.replace(f"{{{{${name}}}}}", f"{{{{{key}}}}}")
        link = f'<a href="{"./" if page == "index.html" else page}"'
        return assembled(static, page, shared.replace(link, f'{link} aria-current="page"'))

    return _PART.sub(part, text)


def parts(
    static: Path, page: str, text: str, languages: Mapping[str, Texts]
) -> tuple[dict[str, str], dict[str, str]]:
    """The HTML of `page` by language, and its sheet and scripts by their paths below `static`."""
    name = page.removesuffix(".html")
    text = assembled(static, page, text)
    made: dict[str, str] = {}
    styles = _SHEET.findall(text)
    if styles:
        made[f"css/all-{name}.css"] = sheet(static, styles)
        text = _SHEET.sub("", text, count=len(styles) - 1)
        text = _SHEET.sub(f'    <link rel="stylesheet" href="css/all-{name}.css">\n', text)
    pages = dict.fromkeys(languages, text)
    entry = _SCRIPT.search(text)
    modules = _modules(static, entry[1]) if entry else {}
    home = posixpath.dirname(entry[1]) if entry else ""
    later = _later(static, home, modules)
    for language, texts in languages.items():
        if entry:
            path = f"{home}/all.{language}.js"
            code = _with_texts(modules, texts)
            for source, its_modules in later.items():
                bundle = f"{source.removesuffix('.js')}.{language}.js"
                code = code.replace(
                    posixpath.relpath(source, home), posixpath.relpath(bundle, home)
                )
                made[bundle] = _with_texts(its_modules, texts) + _exported(source, its_modules)
            made[path] = code
            pages[language] = text.replace(entry[0], f'<script type="module" src="{path}">')
        pages[language] = filled(pages[language], texts)
    return pages, made


def _later(static: Path, home: str, modules: dict[str, str]) -> dict[str, dict[str, str]]:
    """The modules that these fetch later and that have texts, by path, each with its imports."""
    named = [found for code in modules.values() for found in _LATER.findall(code)]
    paths = {posixpath.normpath(posixpath.join(home, each)) for each in named}
    bundled = {path: _modules(static, path) for path in sorted(paths)}
    return {path: each for path, each in bundled.items() if path_of(ENGLISH) in each}


def _exported(path: str, modules: dict[str, str]) -> str:
    """The exports of a bundle for a module at `path`."""
    names = _RETURNED.search(modules[path])
    assert names, f"{path} exports nothing"
    return f"export const {{{names[1]}}} = {_name(path)};\n"


def _with_texts(modules: dict[str, str], texts: Texts) -> str:
    """Modules as one script, with those of these texts that they use, not the English ones."""
    english = path_of(ENGLISH)
    if english not in modules:
        return "".join(modules.values())
    used = used_in("".join(text for path, text in modules.items() if path != english))
    kept = json.dumps({key: texts[key] for key in texts if key in used}, ensure_ascii=False)
    return "".join((modules | {english: _constant(english, kept)}).values())
