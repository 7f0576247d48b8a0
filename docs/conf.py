"""How `make docs` builds the site from these pages; every warning is an error there.

Sphinx builds it: autodoc makes the reference from docstrings, and MyST reads the Markdown that the
repository shows. The build checks links between pages; `make links` checks links to other sites.
"""

import re

import numpy.typing as npt
from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation
from sphinx.writers.html5 import HTML5Translator

from plinko import engine

project = "Plinko"
author = "The Plinko server authors"
release = version = engine.__version__
project_copyright = author

extensions = ["sphinx.ext.autodoc", "sphinx.ext.viewcode", "myst_nb"]
html_theme = "furo"
html_static_path = ["site"]
html_css_files = ["site.css"]
html_title = f"Plinko {release}"

# Markdown: links to headings as on the repository's own pages. Formulas stand in dollars, as there;
# on the site they are MathML, which browsers draw without a script.
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence", "dollarmath", "html_image"]
html_math_renderer = "mathml"

# Docstrings: a name in single backticks is code.
default_role = "code"
autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88

# The build runs the tutorial; a cell that fails stops the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = -1
nb_merge_streams = True

# Scripts of other sites often make their anchors: `make links` checks that their pages exist.
linkcheck_anchors = False

ARRAY_LIKE = stringify_annotation(npt.ArrayLike, "smart")
ARRAY = re.compile(r"~numpy\.ndarray\[tuple\[~typing\.Any, \.\.\.\], ~numpy\.dtype\[(.*?)\]\]")


def _expression(signature: str) -> str:
    return signature.replace("<factory>", "...").replace(ARRAY_LIKE, "~numpy.typing.ArrayLike")


def _as_written(_app: Sphinx, _what: str, _name: str, _value: object, *rest: object) -> object:
    """Write numpy's names for arrays in a signature, not the types that these names stand for.

    Sphinx cannot parse a signature with `<factory>` in it, so that default becomes `...`.
    """
    _options, *both = rest
    return tuple(
        ARRAY.sub(r"~numpy.typing.NDArray[\1]", _expression(text))
        if isinstance(text, str)
        else text
        for text in both
    )


def _inline_formula(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(tex2mathml(node.astext(), as_block=False))
    raise nodes.SkipNode


def _formula(writer: HTML5Translator, node: nodes.math_block) -> None:
    mathml = tex2mathml(node.astext(), as_block=True)
    writer.body.append(f'<div class="formula">{mathml}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Sphinx calls this first."""
    app.connect("autodoc-process-signature", _as_written)
    app.add_html_math_renderer("mathml", (_inline_formula, None), (_formula, None))
