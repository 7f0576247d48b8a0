"""How `make docs` builds the site from these pages; every warning is an error there.

Sphinx builds it, and MyST reads the Markdown that the repository shows. The build checks links
between pages; `make links` checks links to other sites.
"""

import re
import sys
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

from plinko import engine
from plinko.app import settings

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.harness import pages, recorded  # noqa: E402
from tools import reference  # noqa: E402

DRAWN = {
    "measured": recorded.site_text,
    "python-reference": reference.text,
    "server": settings.table,
}
"""By page, what the site shows at its line MARK."""

MARK = "<!-- drawn on the site -->"

project = "Plinko"
author = "The Plinko server authors"
release = version = engine.__version__
project_copyright = author

extensions = ["myst_nb"]
html_theme = "furo"
html_static_path = ["site"]
html_css_files = ["site.css"]
html_title = f"Plinko {release}"

# Markdown: links to headings as on the repository's own pages. Formulas stand in dollars, as there;
# on the site they are MathML, which browsers draw without a script.
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence", "dollarmath", "html_image"]
html_math_renderer = "mathml"

# The build runs the tutorial; a cell that fails stops the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = -1
nb_merge_streams = True

# Scripts of other sites often make their anchors: `make links` checks that their pages exist.
linkcheck_anchors = False


def _inline_formula(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(tex2mathml(node.astext(), as_block=False))
    raise nodes.SkipNode


def _formula(writer: HTML5Translator, node: nodes.math_block) -> None:
    mathml = tex2mathml(node.astext(), as_block=True)
    writer.body.append(f'<div class="formula">{mathml}</div>\n')
    raise nodes.SkipNode


def _draw(_app: Sphinx, page: str, source: list[str]) -> None:
    """Draw what is data in the repository: tables, settings, the Python reference."""
    if page in DRAWN:
        before, after = source[0].split(MARK)  # fails if the page lost its line
        source[0] = before + DRAWN[page]() + after
    source[0] = pages.drawn(source[0], recorded.DOCS)
    source[0] = re.sub(r"\]\(measured/([\w-]+)\.json\)", r"](measured.md#\1)", source[0])


GAME = """\
<iframe src="play/" title="The table" loading="lazy"
  style="width: 100%; height: 40rem; border: 0; border-radius: 0.5rem"></iframe>
<p><a href="play/">Play on a page of its own</a></p>
"""


def _with_game(app: Sphinx, page: str, _: str, context: dict[str, str], __: object) -> None:
    """`make site` builds with the tag `game`: the first page then shows the game next to it."""
    if page == "index" and app.tags.has("game"):
        heading, end, rest = context["body"].partition("</h1>")
        context["body"] = heading + end + GAME + rest


def setup(app: Sphinx) -> None:
    """Sphinx calls this first."""
    app.connect("html-page-context", _with_game)
    app.add_html_math_renderer("mathml", (_inline_formula, None), (_formula, None))
    app.connect("source-read", _draw)
