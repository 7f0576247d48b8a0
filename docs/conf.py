"""How `make docs` makes a site of these pages; every warning is an error there.

Sphinx, as the reference is made from docstrings (autodoc), the pages stay the Markdown that one
reads in the repository (MyST), links between them are checked as they are read, and links to other
sites by `make links`.
"""

import re

import numpy.typing as npt
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

import engine

project = "Plinko"
author = "The Plinko server authors"
release = version = engine.__version__
project_copyright = author

extensions = ["sphinx.ext.autodoc", "sphinx.ext.viewcode", "myst_nb"]
html_theme = "furo"
html_title = f"Plinko {release}"

# Markdown: links to headings as on the repository's own pages.
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]

# Docstrings: a name in single backticks is code.
default_role = "code"
autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88

# The tutorial is run anew, and a cell that fails fails the site.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = -1
nb_merge_streams = True

# Anchors of other sites are often made by their scripts; the pages are checked.
linkcheck_anchors = False

ARRAY_LIKE = stringify_annotation(npt.ArrayLike, "smart")
ARRAY = re.compile(r"~numpy\.ndarray\[tuple\[~typing\.Any, \.\.\.\], ~numpy\.dtype\[(.*?)\]\]")


def _expression(signature: str) -> str:
    return signature.replace("<factory>", "...").replace(ARRAY_LIKE, "~numpy.typing.ArrayLike")


def _as_written(_app: Sphinx, _what: str, _name: str, _value: object, *rest: object) -> object:
    """A signature with numpy's names for arrays, not with what these stand for.

    A default that a factory makes is no expression, with which nothing of it would be read.
    """
    _options, *both = rest
    return tuple(
        ARRAY.sub(r"~numpy.typing.NDArray[\1]", _expression(text))
        if isinstance(text, str)
        else text
        for text in both
    )


def setup(app: Sphinx) -> None:
    """What Sphinx calls first."""
    app.connect("autodoc-process-signature", _as_written)
