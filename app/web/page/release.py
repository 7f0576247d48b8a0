"""Bundles each page: all its modules as one script and its styles as one sheet, in each language.

A page on a slow connection then waits for two files only.

HTML that all pages share is in parts/<name>.part. A page includes it with
`{{> head title=map.title}}`, and the part has `{{$title}}` where the page's text goes.

The bundle does not transpile or rename anything. Each module becomes a function that returns its
exports, after the modules that it imports. Comments and blanks are removed, and the English texts
are replaced by those of one language (languages.py).

A module that a page imports later, by `import("./later.js")`, becomes a bundle as well. That bundle
imports what it shares with the bundles before it, and adds its texts to theirs. A module that only
two later bundles share is in both, so it must not have a state of its own.
"""

import functools
import json
import posixpath
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
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
_LATER = re.compile(r'\bimport\("(\.[^"]+)\.js"\)')
_COMPUTED = re.compile(r'^.*\bimport\((?!")', re.M)
_RETURNED = re.compile(r"return\s*\{([^}]*)\};?\s*\}\)\(\);\s*$")
_SHEET = re.compile(r'    <link rel="stylesheet" href="(css/[^"]+)">\n')
# css/base.css hides the page until a script has set the colours. The bundled sheet has the colours,
# so it shows the page at once.
_SHOWN = 'html:not([style*="--page"]) body {\n  visibility: visible;\n}\n'
_PART = re.compile(r"^ *\{\{> (\w+)((?: \w+=[\w.-]+)*)\}\}\n", re.M)
_TEXTS = path_of(ENGLISH)
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
    text = _LATER.sub(lambda found: f'import("{_from(home, beside(found[1]))}.js")', text)
    if computed := _COMPUTED.search(text):
        raise ValueError(
            f"{path} has {computed[0].strip()!r}: name a module in quotes, so that it is bundled"
        )
    modules.pop(path)
    gives = f"return {{ {', '.join(exports)} }};"
    code = jsmin(f"const {_name(path)} = (() => {{\n{text}{gives}\n}})();")
    modules[path] = f"{code}\n"


def _constant(path: str, value: str) -> str:
    return f"const {_name(path)} = {value};\n"


def _name(path: str) -> str:
    return "m_" + re.sub(r"\W", "_", path)


def _from(home: str, path: str) -> str:
    """How a script in the folder `home` imports the one at `path`."""
    return f"./{posixpath.relpath(path, home)}"


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
    bundles = list(_bundles(static, name, entry[1])) if entry else []
    for language, texts in languages.items():
        for bundle in bundles:
            made[bundle.address(language)] = _code(bundle, bundles, language, texts)
        if entry:
            path = bundles[0].address(language)
            # The first paint waits for the sheet, and for nothing else.
            low = f'<script type="module" fetchpriority="low" src="{path}">'
            pages[language] = text.replace(entry[0], low)
        pages[language] = filled(pages[language], texts)
    return pages, made


@dataclass
class _Bundle:
    """A script: an entry module with its imports that no bundle before it has."""

    page: str  # its name: each page has later bundles of its own, which import its first one
    entry: str
    modules: dict[str, str]  # code by path
    before: tuple["_Bundle", ...]  # the bundles that the page has loaded before, the page's first

    def address(self, language: str) -> str:
        home, file = posixpath.split(self.entry)
        name = f"{file.removesuffix('.js')}-{self.page}" if self.before else "all"
        return f"{home}/{name}.{language}.js"

    def used_by(self, other: "_Bundle") -> list[str]:
        """The names of this bundle's modules that the other one imports."""
        return [name for name in map(_name, self.modules) if name in other.names]

    @functools.cached_property
    def names(self) -> set[str]:
        """The modules that the code uses."""
        return {_name(_TEXTS), *re.findall(r"\bm_\w+", "".join(self.modules.values()))}

    @functools.cached_property
    def texts(self) -> set[str]:
        return used_in("".join(code for path, code in self.modules.items() if path != _TEXTS))


def _bundles(static: Path, page: str, entry: str) -> Iterator[_Bundle]:
    """The page's script, then those that it imports later, each after the ones that it needs."""
    waiting: list[tuple[str, tuple[_Bundle, ...]]] = [(entry, ())]
    seen = {entry}
    for path, before in waiting:
        known = {each for bundle in before for each in bundle.modules}
        modules = {at: code for at, code in _modules(static, path).items() if at not in known}
        bundle = _Bundle(page, path, modules, before)
        yield bundle
        home = posixpath.dirname(path)
        for later in _LATER.findall("".join(modules.values())):
            at = posixpath.normpath(posixpath.join(home, f"{later}.js"))
            if at in modules or at in known:
                raise ValueError(f"{path} imports {at} later, but it has loaded it already")
            if at not in seen:
                seen.add(at)
                waiting.append((at, (*before, bundle)))


def _code(bundle: _Bundle, bundles: list[_Bundle], language: str, texts: Texts) -> str:
    """The bundle as a script, with those of these texts that it uses, not the English ones."""
    home = posixpath.dirname(bundle.entry)
    lines = []
    for other in bundle.before:
        if names := other.used_by(bundle):
            path = _from(home, other.address(language))
            lines.append(f'import {{{", ".join(names)}}} from "{path}";\n')
    used = bundle.texts.difference(*(other.texts for other in bundle.before))
    kept = {key: texts[key] for key in texts if key in used}
    words = json.dumps(kept, ensure_ascii=False)
    if _TEXTS in bundle.modules:
        lines += (bundle.modules | {_TEXTS: _constant(_TEXTS, words)}).values()
    else:
        if kept and any(_TEXTS in other.modules for other in bundle.before):
            lines.append(f"Object.assign({_name(_TEXTS)}, {words});\n")
        lines += bundle.modules.values()
    later = [other for other in bundles if any(bundle is each for each in other.before)]
    shared = sorted({name for other in later for name in bundle.used_by(other)})
    lines += [f"export {{{', '.join(shared)}}};\n"] if shared else []
    if bundle.before:
        given = _RETURNED.search(bundle.modules[bundle.entry])
        assert given, f"{bundle.entry} exports nothing"
        lines.append(f"export const {{{given[1]}}} = {_name(bundle.entry)};\n")
    return _LATER.sub(rf'import("\1-{bundle.page}.{language}.js")', "".join(lines))
